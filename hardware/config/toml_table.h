#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/types/result.h"

namespace faultlab::hardware {

/// One table of a TOML file, read strictly: every key is asked for with its kind and range. A key
/// that is absent leaves the value as it is, its default. A wrong one ends the reading (ReadToml).
class TomlTable {
 public:
  ~TomlTable();
  TomlTable(const TomlTable&) = delete;
  TomlTable& operator=(const TomlTable&) = delete;

  /// The table [key]; an empty one when the file has none. Lives as long as this one.
  TomlTable& Sub(const std::string& key);
  /// The tables [[key]], in the order of the file.
  std::vector<TomlTable*> Subs(const std::string& key);

  void Number(const std::string& key, double& value, double min, double max);
  void Integer(const std::string& key, int& value, int min, int max);
  void Seed(const std::string& key, std::optional<std::uint64_t>& value);
  void Flag(const std::string& key, bool& value);
  void Text(const std::string& key, std::string& value);
  void Texts(const std::string& key, std::vector<std::string>& values);
  void Word(const std::string& key, std::string& value, const std::vector<std::string>& words);
  /// A list of any length.
  void Numbers(const std::string& key, std::vector<double>& values, double min, double max);
  void Integers(const std::string& key, std::vector<int>& values, int min, int max);
  /// One number, or a list of at least one.
  void OneOrMore(const std::string& key, std::vector<int>& values, int min, int max);
  bool Has(const std::string& key) const;
  /// The index of the word.
  int Choice(const std::string& key, int fallback, const std::vector<std::string>& words);
  /// A list of as many numbers as `values` has; `meaning` says what they are.
  void Integers(
      const std::string& key, std::span<int> values, int min, int max, const std::string& meaning);

  /// What the table says, for comparing: without comments, layout and order of its keys.
  std::string Contents() const;

  /// Ends the reading with "FILE:LINE: KEY what".
  [[noreturn]] void Refuse(const std::string& key, const std::string& what) const;

 private:
  friend core::Status ReadToml(std::string_view text,
                               std::string_view file,
                               const std::function<void(TomlTable&)>& read);
  struct State;
  explicit TomlTable(std::unique_ptr<State> state);
  void RefuseWhatNobodyAskedFor() const;

  std::unique_ptr<State> state_;
};

/// Calls `read` with the whole file. What is no TOML, what `read` refuses and what it did not ask
/// for is an Error "FILE:LINE: KEY must be ..", its field the dotted key.
core::Status ReadToml(std::string_view text,
                      std::string_view file,
                      const std::function<void(TomlTable&)>& read);
/// The text of a file; kNotFound.
core::Result<std::string> LoadText(const std::string& path);

}  // namespace faultlab::hardware

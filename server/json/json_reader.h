#pragma once

#include <boost/json/fwd.hpp>
#include <boost/json/object.hpp>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/types/result.h"

namespace faultlab::server {

/// Parses the body of a request. An empty body is {}. Refuses everything except one JSON object.
core::Result<boost::json::object> ParseJsonObject(std::string_view text);

/// Whether a text has control characters but `allowed`, or marks that turn the direction of what
/// follows.
bool HasControlCharacter(std::string_view text, std::string_view allowed = "");

/// Reads one JSON object strictly: members are read by name, and Finish() refuses members that were
/// not read. The first refusal is stored, with a JSON pointer to the member; later reads return
/// their fallback, so that a parser needs to check the error only once.
///
///   ObjectReader in(object, "/excitation");
///   spec.low_v = in.NumberOr("low_v", 2.0, -10, 10);
///   if (auto error = in.Finish()) return *error;
class ObjectReader {
 public:
  ObjectReader(const boost::json::object& object, std::string pointer)
      : object_(object), pointer_(std::move(pointer)) {}

  bool Has(std::string_view name);
  /// lo <= value <= hi, finite.
  double Number(std::string_view name, double lo, double hi);
  double NumberOr(std::string_view name, double fallback, double lo, double hi);
  std::int64_t Integer(std::string_view name, std::int64_t lo, std::int64_t hi);
  std::int64_t IntegerOr(std::string_view name,
                         std::int64_t fallback,
                         std::int64_t lo,
                         std::int64_t hi);
  bool BooleanOr(std::string_view name, bool fallback);
  /// UTF-8 without control characters, at most `bytes_max` bytes.
  std::string Text(std::string_view name, std::size_t bytes_max);
  std::string TextOr(std::string_view name, std::string fallback, std::size_t bytes_max);
  /// The same with line breaks and tabs.
  std::string ProseOr(std::string_view name, std::string fallback, std::size_t bytes_max);
  /// One of the words; a refusal lists them. Returns the first word on failure.
  std::string_view WordOr(std::string_view name,
                          std::string_view fallback,
                          std::initializer_list<std::string_view> words);
  /// Null when absent or refused.
  const boost::json::object* ObjectOrNull(std::string_view name);
  const boost::json::array* ArrayOrNull(std::string_view name, std::size_t size_max);

  /// Refuses `name` for a reason of core::Refuse.
  void Refuse(std::string_view name,
              std::string_view reason,
              std::vector<core::ErrorParameter> parameters = {});
  void Refuse(core::Error error);

  const std::optional<core::Error>& error() const { return error_; }
  std::string Pointer(std::string_view name) const;
  /// The first refusal; an unknown member is refused too.
  std::optional<core::Error> Finish();

 private:
  const boost::json::value* Find(std::string_view name);
  std::string ReadText(std::string_view name,
                       std::string fallback,
                       std::size_t bytes_max,
                       std::string_view allowed);
  void RefuseKind(std::string_view name, const std::string& expected);

  const boost::json::object& object_;
  std::string pointer_;
  std::set<std::string, std::less<>> asked_;
  std::optional<core::Error> error_;
};

}  // namespace faultlab::server

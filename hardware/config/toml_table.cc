#include "hardware/config/toml_table.h"
#include "core/types/number_text.h"

#include <stdexcept>

/// toml++ 3.3 asserts on some texts that are no TOML ("[\x01"): a settings file is not to end the
/// program.
constexpr void CheckToml(bool holds, const char* what) {
  if (!holds) throw std::logic_error(what);
}
#define TOML_ASSERT(expr) CheckToml(static_cast<bool>(expr), #expr)
#include <toml++/toml.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <utility>

namespace faultlab::hardware {
namespace {

/// Raised while a file is read, caught in ReadToml.
struct Refusal {
  std::string key;
  std::string what;
  toml::source_region where;
};

std::string TextOf(double value) {
  return core::Format("%.10g", value);
}

bool IsWhole(const toml::node& node, std::int64_t min, std::int64_t max) {
  const auto value = node.value_exact<std::int64_t>();
  return value && *value >= min && *value <= max;
}

std::string WholeFrom(int min, int max) {
  return " from " + std::to_string(min) + " to " + std::to_string(max);
}

/// 6 and 6.0 say the same.
void WriteWholeNumbersAsOthers(toml::table& table);

void WriteWholeNumbersAsOthers(toml::array& array) {
  for (std::size_t i = 0; i < array.size(); ++i) {
    toml::node& node = array[i];
    if (toml::table* table = node.as_table()) WriteWholeNumbersAsOthers(*table);
    if (toml::array* inner = node.as_array()) WriteWholeNumbersAsOthers(*inner);
    if (const auto whole = node.value_exact<std::int64_t>()) {
      array.replace(array.cbegin() + static_cast<std::ptrdiff_t>(i), static_cast<double>(*whole));
    }
  }
}

void WriteWholeNumbersAsOthers(toml::table& table) {
  for (auto&& [key, node] : table) {
    if (toml::table* inner = node.as_table()) WriteWholeNumbersAsOthers(*inner);
    if (toml::array* array = node.as_array()) WriteWholeNumbersAsOthers(*array);
    if (const auto whole = node.value_exact<std::int64_t>()) {
      table.insert_or_assign(key, static_cast<double>(*whole));
    }
  }
}

core::Error ErrorAt(std::string_view file,
                    const toml::source_region& where,
                    const std::string& message,
                    const std::string& key) {
  // What is not in the file has no line.
  const std::string line =
      where.begin.line > 0 ? ":" + std::to_string(where.begin.line) : std::string();
  return core::Error{.code = core::ErrorCode::kInvalid,
                     .message = std::string(file) + line + ": " + message,
                     .field = key};
}

}  // namespace

struct TomlTable::State {
  const toml::table* table = nullptr;
  std::string prefix;
  std::set<std::string> asked;
  std::map<std::string, std::unique_ptr<TomlTable>> subs;

  /// The key's node, if it is in the file.
  const toml::node* Find(const std::string& key) {
    asked.insert(key);
    return table->get(key);
  }
};

TomlTable::TomlTable(std::unique_ptr<State> state) : state_(std::move(state)) {}
TomlTable::~TomlTable() = default;

TomlTable& TomlTable::Sub(const std::string& key) {
  static const toml::table kEmpty;
  const toml::node* node = state_->Find(key);
  const std::string path = state_->prefix + key;
  if (node != nullptr && !node->is_table()) Refuse(key, "must be a table: [" + path + "]");
  std::unique_ptr<TomlTable>& sub = state_->subs[key];
  if (sub == nullptr) {
    auto state = std::make_unique<State>();
    state->table = node != nullptr ? node->as_table() : &kEmpty;
    state->prefix = path + ".";
    sub.reset(new TomlTable(std::move(state)));
  }
  return *sub;
}

std::vector<TomlTable*> TomlTable::Subs(const std::string& key) {
  std::vector<TomlTable*> out;
  const toml::node* node = state_->Find(key);
  if (node == nullptr) return out;
  const std::string path = state_->prefix + key;
  if (!node->is_array_of_tables()) Refuse(key, "must be a list of tables: [[" + path + "]]");
  for (const toml::node& entry : *node->as_array()) {
    auto state = std::make_unique<State>();
    state->table = entry.as_table();
    state->prefix = path + ".";
    const std::string name = key + "[" + std::to_string(out.size()) + "]";
    std::unique_ptr<TomlTable>& sub = state_->subs[name];
    sub.reset(new TomlTable(std::move(state)));
    out.push_back(sub.get());
  }
  return out;
}

void TomlTable::Number(const std::string& key, double& value, double min, double max) {
  const toml::node* node = state_->Find(key);
  if (node == nullptr) return;
  const auto number = node->is_number() ? node->value<double>() : std::nullopt;
  if (!number || !(*number >= min && *number <= max)) {
    Refuse(key, "must be a number from " + TextOf(min) + " to " + TextOf(max));
  }
  value = *number;
}

void TomlTable::Integer(const std::string& key, int& value, int min, int max) {
  const toml::node* node = state_->Find(key);
  if (node == nullptr) return;
  if (!IsWhole(*node, min, max)) Refuse(key, "must be a whole number" + WholeFrom(min, max));
  value = static_cast<int>(*node->value<std::int64_t>());
}

void TomlTable::Seed(const std::string& key, std::optional<std::uint64_t>& value) {
  const toml::node* node = state_->Find(key);
  if (node == nullptr) return;
  if (!IsWhole(*node, 0, INT64_MAX)) Refuse(key, "must be a whole number, 0 or more");
  value = static_cast<std::uint64_t>(*node->value<std::int64_t>());
}

void TomlTable::Flag(const std::string& key, bool& value) {
  const toml::node* node = state_->Find(key);
  if (node == nullptr) return;
  if (!node->is_boolean()) Refuse(key, "must be true or false");
  value = *node->value<bool>();
}

void TomlTable::Text(const std::string& key, std::string& value) {
  const toml::node* node = state_->Find(key);
  if (node == nullptr) return;
  if (!node->is_string()) Refuse(key, "must be a text in quotes");
  value = *node->value<std::string>();
}

void TomlTable::Texts(const std::string& key, std::vector<std::string>& values) {
  const toml::node* node = state_->Find(key);
  if (node == nullptr) return;
  const toml::array* list = node->as_array();
  if (list == nullptr) Refuse(key, "must be a list of texts in quotes");
  std::vector<std::string> read;
  for (const toml::node& entry : *list) {
    if (!entry.is_string()) Refuse(key, "must be a list of texts in quotes");
    read.push_back(*entry.value<std::string>());
  }
  values = std::move(read);
}

void TomlTable::Numbers(const std::string& key,
                        std::vector<double>& values,
                        double min,
                        double max) {
  const toml::node* node = state_->Find(key);
  if (node == nullptr) return;
  std::vector<double> read;
  if (const toml::array* list = node->as_array()) {
    for (const toml::node& entry : *list) {
      const auto number = entry.is_number() ? entry.value<double>() : std::nullopt;
      if (number && *number >= min && *number <= max) read.push_back(*number);
    }
    if (read.size() == list->size()) {
      values = std::move(read);
      return;
    }
  }
  Refuse(key, "must be a list of numbers from " + TextOf(min) + " to " + TextOf(max));
}

void TomlTable::Integers(const std::string& key, std::vector<int>& values, int min, int max) {
  const toml::node* node = state_->Find(key);
  if (node == nullptr) return;
  std::vector<int> read;
  if (const toml::array* list = node->as_array()) {
    for (const toml::node& entry : *list) {
      if (IsWhole(entry, min, max)) read.push_back(static_cast<int>(*entry.value<std::int64_t>()));
    }
    if (read.size() == list->size()) {
      values = std::move(read);
      return;
    }
  }
  Refuse(key, "must be a list of whole numbers" + WholeFrom(min, max));
}

void TomlTable::OneOrMore(const std::string& key, std::vector<int>& values, int min, int max) {
  const toml::node* node = state_->Find(key);
  if (node == nullptr) return;
  if (IsWhole(*node, min, max)) {
    values = {static_cast<int>(*node->value<std::int64_t>())};
    return;
  }
  const toml::array* list = node->as_array();
  if (list == nullptr || list->empty()) {
    Refuse(key, "must be a whole number, or a list of them," + WholeFrom(min, max));
  }
  Integers(key, values, min, max);
}

bool TomlTable::Has(const std::string& key) const {
  return state_->table->contains(key);
}

void TomlTable::Word(const std::string& key,
                     std::string& value,
                     const std::vector<std::string>& words) {
  const int index = Choice(key, -1, words);
  if (index >= 0) value = words[static_cast<std::size_t>(index)];
}

int TomlTable::Choice(const std::string& key, int fallback, const std::vector<std::string>& words) {
  const toml::node* node = state_->Find(key);
  if (node == nullptr) return fallback;
  const auto word = node->value_exact<std::string>();
  const auto found = std::find(words.begin(), words.end(), word.value_or(""));
  if (word && found != words.end()) return static_cast<int>(found - words.begin());
  std::string all;
  for (const std::string& each : words) all += (all.empty() ? "" : ", ") + each;
  Refuse(key, "must be one of " + all);
}

void TomlTable::Integers(
    const std::string& key, std::span<int> values, int min, int max, const std::string& meaning) {
  const toml::node* node = state_->Find(key);
  if (node == nullptr) return;
  const toml::array* list = node->as_array();
  const bool all_whole =
      list != nullptr && list->size() == values.size() &&
      std::all_of(list->begin(), list->end(), [min, max](const toml::node& entry) {
        return IsWhole(entry, min, max);
      });
  if (!all_whole) {
    Refuse(key,
           "must be " + std::to_string(values.size()) + " whole numbers" + WholeFrom(min, max) +
               ": " + meaning);
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = static_cast<int>(*list->get(i)->value<std::int64_t>());
  }
}

void TomlTable::Refuse(const std::string& key, const std::string& what) const {
  const toml::node* node = state_->table->get(key);
  // A key that is missing is missed where its table begins; the whole file begins nowhere.
  const bool whole_file = state_->prefix.empty();
  toml::source_region where{};
  if (node != nullptr) {
    where = node->source();
  } else if (!whole_file) {
    where = state_->table->source();
  }
  throw Refusal{.key = state_->prefix + key, .what = what, .where = where};
}

void TomlTable::RefuseWhatNobodyAskedFor() const {
  for (const auto& [key, node] : *state_->table) {
    const std::string name(key.str());
    if (!state_->asked.contains(name)) Refuse(name, "is not a key of this table");
  }
  for (const auto& [key, sub] : state_->subs) sub->RefuseWhatNobodyAskedFor();
}

std::string TomlTable::Contents() const {
  toml::table plain = *state_->table;
  WriteWholeNumbersAsOthers(plain);
  std::ostringstream out;
  out << toml::json_formatter(plain);
  return std::move(out).str();
}

core::Status ReadToml(std::string_view text,
                      std::string_view file,
                      const std::function<void(TomlTable&)>& read) {
  try {
    const toml::table table = toml::parse(text, file);
    auto state = std::make_unique<TomlTable::State>();
    state->table = &table;
    TomlTable root(std::move(state));
    read(root);
    root.RefuseWhatNobodyAskedFor();
    return core::Done{};
  } catch (const toml::parse_error& error) {
    return ErrorAt(file, error.source(), std::string(error.description()), "");
  } catch (const std::logic_error& error) {
    return core::Error{.code = core::ErrorCode::kInvalid,
                       .message = std::string(file) + ": this is no TOML: " + error.what(),
                       .field = {}};
  } catch (const Refusal& refusal) {
    return ErrorAt(file, refusal.where, refusal.key + " " + refusal.what, refusal.key);
  }
}

core::Result<std::string> LoadText(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  std::error_code none;
  if (in && !std::filesystem::is_directory(path, none)) return std::move(text).str();
  return core::Error{.code = core::ErrorCode::kNotFound,
                     .message = path + " cannot be read; is it a file?",
                     .field = {}};
}

}  // namespace faultlab::hardware

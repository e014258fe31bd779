#pragma once

#include <soci/soci.h>

#include <algorithm>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "core/types/check.h"
#include "server/storage/database.h"
#include "server/wall_time.h"

// How the members of a row become the parameters of a statement, and its columns members again
// (rows.h).
namespace faultlab::server {

namespace rows {

template <typename Value>
std::int64_t ToNumber(const Value& value) {
  return static_cast<std::int64_t>(value);
}
inline std::int64_t ToNumber(const WallTime& time) {
  return ToMilliseconds(time);
}
inline std::int64_t ToNumber(const std::chrono::milliseconds& duration) {
  return duration.count();
}
inline std::int64_t ToNumber(const std::optional<WallTime>& time) {
  return time ? ToMilliseconds(*time) : 0;
}
template <typename Value>
void FromNumber(std::int64_t number, Value& value) {
  value = static_cast<Value>(number);
}
inline void FromNumber(std::int64_t number, bool& value) {
  value = number != 0;
}
inline void FromNumber(std::int64_t number, WallTime& time) {
  time = FromMilliseconds(number);
}
inline void FromNumber(std::int64_t number, std::chrono::milliseconds& duration) {
  duration = std::chrono::milliseconds{number};
}
inline void FromNumber(std::int64_t number, std::optional<WallTime>& time) {
  time = number == 0 ? std::nullopt : std::optional(FromMilliseconds(number));
}

}  // namespace rows

/// Stands in a query as `:name`.
struct Parameter {
  Parameter(std::string name_, std::string_view text)
      : name(std::move(name_)), value(std::string(text)) {}
  Parameter(std::string name_, double number) : name(std::move(name_)), value(number) {}
  template <typename Value>
  requires(!std::is_convertible_v<Value, std::string_view> && !std::is_floating_point_v<Value>)
      Parameter(std::string name_, const Value& number)
      : name(std::move(name_)), value(rows::ToNumber(number)) {}

  Parameter(std::string name_, const Parameter& other)
      : name(std::move(name_)), value(other.value) {}

  std::string name;
  std::variant<std::int64_t, double, std::string> value;
};
using Parameters = std::vector<Parameter>;

/// What rows have to be, piece by piece: "1 = 1 AND rig = :rig".
struct Condition {
  void And(const std::string& piece, const Parameters& more = {}) {
    sql += " AND " + piece;
    parameters.insert(parameters.end(), more.begin(), more.end());
  }
  std::string sql = "1 = 1";
  Parameters parameters;
};

namespace rows {

inline std::string Insert(const std::string& table, const Parameters& columns) {
  std::string names;
  std::string values;
  for (const auto& [name, value] : columns) {
    names += (names.empty() ? "" : ", ") + name;
    values += (values.empty() ? ":" : ", :") + name;
  }
  return "INSERT INTO " + table + " (" + names + ") VALUES (" + values + ")";
}
/// "rig = :rig AND owner = :owner".
inline std::string Equal(const Parameters& columns, const char* prefix, const char* between) {
  std::string all;
  for (const auto& [name, value] : columns) {
    all += (all.empty() ? "" : between) + (name + " = :" + prefix) + name;
  }
  return all;
}

/// Binds the fields of one row to `:name` parameters.
class Writer {
 public:
  /// @param only  of these columns; empty: of all
  /// @param but   not of this one
  explicit Writer(soci::statement& statement,
                  std::span<const std::string_view> only = {},
                  std::string_view but = {})
      : statement_(statement), only_(only), but_(but) {}

  void operator()(const char* name, std::string& text) {
    if (Takes(name)) statement_.exchange(soci::use(text, name));
  }
  void operator()(const char* name, double& number) {
    if (Takes(name)) statement_.exchange(soci::use(number, name));
  }
  template <typename Value>
  void operator()(const char* name, Value& value) {
    if (Takes(name)) statement_.exchange(soci::use(numbers_.emplace_back(ToNumber(value)), name));
  }
  template <typename Value, typename Words>
  void operator()(const char* name, Value& value, const Words& words) {
    if (!Takes(name)) return;
    if constexpr (requires { words.Write(value); }) {
      statement_.exchange(soci::use(texts_.emplace_back(words.Write(value)), name));
    } else {
      const auto at = static_cast<std::size_t>(value);
      statement_.exchange(soci::use(texts_.emplace_back(words[at]), name));
    }
  }

  std::string Insert(const std::string& table) const {
    return "INSERT INTO " + table + " (" + Joined("") + ") VALUES (" + Joined(":") + ")";
  }
  /// The first field is the key.
  std::string Upsert(const std::string& table) const {
    return Insert(table) + " ON CONFLICT (" + names_.front() + ") DO UPDATE SET " +
           Assigned("excluded.");
  }
  std::string Update(const std::string& table) const {
    return "UPDATE " + table + " SET " + Assigned(":");
  }

 private:
  bool Takes(const char* name) {
    if (name == but_) return false;
    if (!only_.empty() && std::ranges::find(only_, name) == only_.end()) return false;
    names_.emplace_back(name);
    return true;
  }
  std::string Joined(const char* prefix) const {
    std::string all;
    for (const std::string& name : names_) all += (all.empty() ? "" : ", ") + (prefix + name);
    return all;
  }
  std::string Assigned(const char* prefix) const {
    std::string all;
    for (const std::string& name : names_) {
      if (only_.empty() && name == names_.front()) continue;
      all += (all.empty() ? "" : ", ") + name + " = " + prefix + name;
    }
    return all;
  }

  soci::statement& statement_;
  std::span<const std::string_view> only_;
  std::string_view but_;
  std::deque<std::int64_t> numbers_;
  std::deque<std::string> texts_;
  std::vector<std::string> names_;
};

/// Binds the fields of one row to the columns of a result.
class Reader {
 public:
  explicit Reader(soci::statement& statement) : statement_(statement) {}

  void operator()(const char* name, std::string& text) {
    statement_.exchange(soci::into(text));
    Add(name);
  }
  void operator()(const char* name, double& number) {
    statement_.exchange(soci::into(number));
    Add(name);
  }
  template <typename Value>
  void operator()(const char* name, Value& value) {
    std::int64_t& number = numbers_.emplace_back();
    soci::indicator& indicator = indicators_.emplace_back(soci::i_ok);
    statement_.exchange(soci::into(number, indicator));
    setters_.emplace_back([&number, &indicator, &value] {
      FromNumber(indicator == soci::i_null ? 0 : number, value);
    });
    Add(name);
  }
  template <typename Value, typename Words>
  void operator()(const char* name, Value& value, const Words& words) {
    std::string& text = texts_.emplace_back();
    statement_.exchange(soci::into(text));
    if constexpr (requires { words.Read(text); }) {
      setters_.emplace_back([&text, &value] { value = Words::Read(text); });
    } else {
      setters_.emplace_back([&text, &value, &words] {
        const auto found = std::find(std::begin(words), std::end(words), text);
        LAB_CHECK(found != std::end(words), text);
        value = static_cast<Value>(found - std::begin(words));
      });
    }
    Add(name);
  }
  const std::string& columns() const { return columns_; }
  void Finish() const {
    for (const auto& set : setters_) set();
  }

 private:
  void Add(const char* name) { columns_ += (columns_.empty() ? "" : ", ") + std::string(name); }

  soci::statement& statement_;
  std::deque<std::int64_t> numbers_;
  std::deque<soci::indicator> indicators_;
  std::deque<std::string> texts_;
  std::vector<std::function<void()>> setters_;
  std::string columns_;
};

}  // namespace rows

}  // namespace faultlab::server

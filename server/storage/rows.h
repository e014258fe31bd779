#pragma once

#include <soci/soci.h>

#include <algorithm>
#include <deque>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "core/types/check.h"
#include "server/storage/database.h"
#include "server/wall_time.h"

// Rows of tables. A row's columns are listed once, beside its type:
//
//   template <typename Visit>
//   void Fields(Trial& trial, Visit&& visit) {
//     visit("id", trial.id);                    // the key comes first
//     visit("state", trial.state, kStates);     // an enum as one of these words
//     visit("ended_ms", trial.ended_at);        // an optional time: 0 or NULL is none
//     visit("kinds", trial.kinds, KindsText{}); // whatever has a Write and a Read
//   }
//
// A word that is added to a list needs a step of the schema, which refuses programs that do not
// know it. Enums without words, flags, durations and times are stored as whole numbers.
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

inline void Bind(soci::statement& statement, const Parameters& parameters) {
  for (const Parameter& parameter : parameters) {
    std::visit([&](const auto& value) { statement.exchange(soci::use(value, parameter.name)); },
               parameter.value);
  }
}

inline std::int64_t Execute(soci::statement& statement, const std::string& query) {
  statement.alloc();
  statement.prepare(query, soci::details::st_one_time_query);
  statement.define_and_bind();
  statement.execute(true);
  return statement.get_affected_rows();
}

template <typename Row, typename Each>
void Fetch(Row& row,
           soci::statement& statement,
           const Reader& reader,
           const std::string& query,
           const Parameters& parameters,
           const Each& each) {
  Bind(statement, parameters);
  statement.alloc();
  statement.prepare(query);
  statement.define_and_bind();
  statement.execute(false);
  while (statement.fetch()) {
    reader.Finish();
    if constexpr (std::is_same_v<decltype(each(row)), bool>) {
      if (!each(row)) return;
    } else {
      each(row);
    }
  }
}

}  // namespace rows

/// Runs a statement that gives no rows. @returns how many it changed
inline std::int64_t Execute(Transaction& tx,
                            const std::string& query,
                            const Parameters& parameters = {}) {
  soci::statement statement(tx.sql());
  rows::Bind(statement, parameters);
  return rows::Execute(statement, query);
}

/// A row of these columns.
/// @param conflict  "ON CONFLICT (rig) DO NOTHING"
/// @returns how many rows are new or changed
inline std::int64_t InsertInto(Transaction& tx,
                               const std::string& table,
                               const Parameters& columns,
                               const std::string& conflict = "") {
  return Execute(tx, rows::Insert(table, columns) + " " + conflict, columns);
}

/// The rows with these values. @returns how many there were
inline std::int64_t DeleteFrom(Transaction& tx, const std::string& table, const Parameters& where) {
  return Execute(tx, "DELETE FROM " + table + " WHERE " + rows::Equal(where, "", " AND "), where);
}

/// Sets columns of the rows with these values. @returns how many there were
inline std::int64_t UpdateWhere(Transaction& tx,
                                const std::string& table,
                                const Parameters& set,
                                const Parameters& where) {
  Parameters both;
  for (const Parameter& one : set) both.emplace_back("new_" + one.name, one);
  both.insert(both.end(), where.begin(), where.end());
  return Execute(tx,
                 "UPDATE " + table + " SET " + rows::Equal(set, "new_", ", ") + " WHERE " +
                     rows::Equal(where, "", " AND "),
                 both);
}

/// @param from  "trial WHERE id = :id ORDER BY id"
/// @param each  of a row; no further row is read after it has returned false
template <typename Row, typename Each>
void ForEachRow(Transaction& tx,
                const std::string& from,
                const Each& each,
                const Parameters& parameters = {}) {
  Row row;
  soci::statement statement(tx.sql());
  rows::Reader reader(statement);
  Fields(row, reader);
  rows::Fetch(
      row, statement, reader, "SELECT " + reader.columns() + " FROM " + from, parameters, each);
}

template <typename Row>
std::vector<Row> SelectRows(Transaction& tx,
                            const std::string& from,
                            const Parameters& parameters = {}) {
  std::vector<Row> all;
  ForEachRow<Row>(
      tx, from, [&](const Row& row) { all.push_back(row); }, parameters);
  return all;
}

template <typename Row>
std::optional<Row> SelectRow(Transaction& tx,
                             const std::string& from,
                             const Parameters& parameters = {}) {
  std::vector<Row> found = SelectRows<Row>(tx, from, parameters);
  return found.empty() ? std::nullopt : std::optional(std::move(found.front()));
}

/// Columns that make no row of a table: "SELECT rig, COUNT(*) FROM ..".
template <typename... Column>
std::vector<std::tuple<Column...>> SelectTuples(Transaction& tx,
                                                const std::string& query,
                                                const Parameters& parameters = {}) {
  std::vector<std::tuple<Column...>> all;
  std::tuple<Column...> row;
  soci::statement statement(tx.sql());
  rows::Reader reader(statement);
  std::apply([&](auto&... column) { (reader("", column), ...); }, row);
  rows::Fetch(
      row, statement, reader, query, parameters, [&](const auto& one) { all.push_back(one); });
  return all;
}

/// Of the first row.
template <typename... Column>
std::optional<std::tuple<Column...>> SelectTuple(Transaction& tx,
                                                 const std::string& query,
                                                 const Parameters& parameters = {}) {
  auto found = SelectTuples<Column...>(tx, query, parameters);
  return found.empty() ? std::nullopt : std::optional(std::move(found.front()));
}

/// Of the only column.
template <typename Value>
std::vector<Value> SelectColumn(Transaction& tx,
                                const std::string& query,
                                const Parameters& parameters = {}) {
  std::vector<Value> all;
  for (auto& [value] : SelectTuples<Value>(tx, query, parameters)) all.push_back(std::move(value));
  return all;
}

/// Of the first row's only column.
template <typename Value>
std::optional<Value> SelectValue(Transaction& tx,
                                 const std::string& query,
                                 const Parameters& parameters = {}) {
  std::vector<Value> found = SelectColumn<Value>(tx, query, parameters);
  return found.empty() ? std::nullopt : std::optional(std::move(found.front()));
}

/// @returns the "id" that the row got
inline std::int64_t AddInto(Transaction& tx, const std::string& table, const Parameters& columns) {
  return *SelectValue<std::int64_t>(tx, rows::Insert(table, columns) + " RETURNING id", columns);
}

/// @param from  "trial WHERE run = :run"
inline std::int64_t CountRows(Transaction& tx,
                              const std::string& from,
                              const Parameters& parameters = {}) {
  return SelectColumn<std::int64_t>(tx, "SELECT COUNT(*) FROM " + from, parameters).front();
}

/// Without its "id". @returns the id that it got
template <typename Row>
std::int64_t AddRow(Transaction& tx, const std::string& table, Row row) {
  std::int64_t id = 0;
  soci::statement statement(tx.sql());
  rows::Writer writer(statement, {}, "id");
  Fields(row, writer);
  statement.exchange(soci::into(id));
  rows::Execute(statement, writer.Insert(table) + " RETURNING id");
  return id;
}

/// @param but  without this column
template <typename Row>
void InsertRow(Transaction& tx, const std::string& table, Row row, std::string_view but = {}) {
  soci::statement statement(tx.sql());
  rows::Writer writer(statement, {}, but);
  Fields(row, writer);
  rows::Execute(statement, writer.Insert(table));
}

/// In place of a row with the same key.
template <typename Row>
void PutRow(Transaction& tx, const std::string& table, Row row) {
  soci::statement statement(tx.sql());
  rows::Writer writer(statement);
  Fields(row, writer);
  rows::Execute(statement, writer.Upsert(table));
}

/// These columns of the rows of which `condition` is true. @returns how many there were
template <typename Row>
std::int64_t ChangeRows(Transaction& tx,
                        const std::string& table,
                        Row row,
                        std::span<const std::string_view> columns,
                        const std::string& condition,
                        const Parameters& parameters = {}) {
  soci::statement statement(tx.sql());
  rows::Writer writer(statement, columns);
  Fields(row, writer);
  rows::Bind(statement, parameters);
  return rows::Execute(statement, writer.Update(table) + " WHERE " + condition);
}

}  // namespace faultlab::server

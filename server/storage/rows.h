#pragma once

#include <soci/soci.h>

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "server/storage/database.h"
#include "server/storage/row_binding.h"

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

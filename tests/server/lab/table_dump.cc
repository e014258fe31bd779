#include "tests/server/lab/table_dump.h"

#include <soci/soci.h>

#include <array>
#include <stdexcept>

namespace faultlab::tests {
namespace {

struct Table {
  const char* name;
  const char* columns;  ///< the key first
};
constexpr std::array<Table, 12> kTables = {
    {{"lab_meta", "*"},
     {"lab_rig", "*"},
     {"lab_outage", "*"},
     {"lab_ticket", "*"},
     {"lab_booking", "*"},
     {"lab_session", "*"},
     {"lab_usage", "*"},
     {"lab_event", "*"},
     {"job",
      "id, owner, account_id, batch, name, body, body_bytes, run_name, rig, recording, state, "
      "run_id, error, result, created_ms, started_ms, ended_ms, server_id, length(boot) AS boot, "
      "attempts"},
     {"recording", "*"},
     {"recording_event", "recording_id || '/' || seq AS k, kind, json"},
     {"blob_store", "owner || '/' || seq AS k, length(bytes) AS bytes"}}};

std::string Text(const soci::row& row, std::size_t i) {
  if (row.get_indicator(i) == soci::i_null) return "null";
  switch (row.get_properties(i).get_data_type()) {
    case soci::dt_string:
      return row.get<std::string>(i);
    case soci::dt_integer:
      return std::to_string(row.get<int>(i));
    case soci::dt_long_long:
      return std::to_string(row.get<long long>(i));
    case soci::dt_double:
      return std::to_string(row.get<double>(i));
    default:
      throw std::runtime_error("a column of an unexpected type: " +
                               row.get_properties(i).get_name());
  }
}

}  // namespace

TableDump DumpTables(server::Database& database) {
  TableDump dump;
  const core::Status read = database.Read([&](server::Transaction& tx) -> core::Status {
    for (const Table& table : kTables) {
      const std::string query = std::string("SELECT ") + table.columns + " FROM " + table.name;
      const soci::rowset<soci::row> rows = (tx.sql().prepare << query);
      for (const soci::row& row : rows) {
        Row& out = dump[std::string(table.name) + " " + Text(row, 0)];
        for (std::size_t i = 1; i < row.size(); ++i) {
          out[row.get_properties(i).get_name()] = Text(row, i);
        }
      }
    }
    return core::Done{};
  });
  if (!read.ok()) throw std::runtime_error(read.error().message);
  return dump;
}

std::string FirstDifference(const TableDump& a, const TableDump& b) {
  for (const auto& [key, row] : a) {
    const auto other = b.find(key);
    if (other == b.end()) return key + " is in the first only";
    for (const auto& [column, value] : row) {
      const std::string& theirs = other->second.at(column);
      if (theirs != value) return key + " " + column + ": " + value + " and " + theirs;
    }
  }
  for (const auto& [key, row] : b) {
    if (!a.contains(key)) return key + " is in the second only";
  }
  return {};
}

}  // namespace faultlab::tests

#include "server/storage/blob_store.h"

#include <libpq-fe.h>
#include <soci/postgresql/soci-postgresql.h>
#include <soci/soci.h>

#include <array>
#include <limits>
#include <utility>

#include "core/types/check.h"
#include "server/storage/rows.h"

namespace faultlab::server::blob_store {
namespace {

using Found = std::optional<std::pair<std::int64_t, Bytes>>;

/// One statement through libpq on SOCI's own connection, so that it is part of SOCI's transaction.
class PostgresQuery {
 public:
  PostgresQuery(Transaction& tx,
                const char* statement,
                std::span<const char* const> values,
                std::span<const int> lengths,
                std::span<const int> formats) {
    auto* backend = static_cast<soci::postgresql_session_backend*>(tx.sql().get_backend());
    result_ = PQexecParams(backend->conn_,
                           statement,
                           static_cast<int>(values.size()),
                           nullptr,
                           values.data(),
                           lengths.data(),
                           formats.data(),
                           /*resultFormat=*/1);
    const ExecStatusType status = PQresultStatus(result_);
    if (status == PGRES_COMMAND_OK || status == PGRES_TUPLES_OK) return;
    const char* field = PQresultErrorField(result_, PG_DIAG_SQLSTATE);
    const std::string state = field != nullptr ? field : "08006";
    PQclear(result_);
    throw soci::postgresql_soci_error(PQerrorMessage(backend->conn_), state.c_str());
  }
  ~PostgresQuery() { PQclear(result_); }
  PostgresQuery(const PostgresQuery&) = delete;
  PostgresQuery& operator=(const PostgresQuery&) = delete;

  int rows() const { return PQntuples(result_); }
  std::int64_t Integer(int column) const {
    LAB_CHECK(PQgetlength(result_, 0, column) == 8);
    const char* text = PQgetvalue(result_, 0, column);
    std::uint64_t value = 0;  // network byte order
    for (int i = 0; i < 8; ++i) value = (value << 8) | static_cast<unsigned char>(text[i]);
    return static_cast<std::int64_t>(value);
  }
  Bytes Blob(int column) const {
    const auto* data = reinterpret_cast<const std::byte*>(PQgetvalue(result_, 0, column));
    return {data, data + PQgetlength(result_, 0, column)};
  }

 private:
  PGresult* result_ = nullptr;
};

void PutPostgres(Transaction& tx,
                 const std::string& owner,
                 std::int64_t sequence,
                 std::span<const std::byte> bytes) {
  LAB_CHECK(bytes.size() <= static_cast<std::size_t>(std::numeric_limits<int>::max()));
  const std::string number = std::to_string(sequence);
  const std::array<const char*, 3> values = {
      owner.c_str(), number.c_str(), reinterpret_cast<const char*>(bytes.data())};
  const std::array<const char*, 3> empty = {owner.c_str(), number.c_str(), ""};
  const std::array<int, 3> lengths = {0, 0, static_cast<int>(bytes.size())};
  const std::array<int, 3> formats = {0, 0, 1};
  PostgresQuery(tx,
                "INSERT INTO blob_store (owner, seq, bytes) VALUES ($1, $2::bigint, $3::bytea)",
                bytes.empty() ? empty : values,
                lengths,
                formats);
}

Found NextPostgres(Transaction& tx, const std::string& owner, std::int64_t from, std::int64_t to) {
  const std::string first = std::to_string(from);
  const std::string last = std::to_string(to);
  const std::array<const char*, 3> values = {owner.c_str(), first.c_str(), last.c_str()};
  const std::array<int, 3> lengths = {0, 0, 0};
  const std::array<int, 3> formats = {0, 0, 0};
  const PostgresQuery query(tx,
                            "SELECT seq, bytes FROM blob_store WHERE owner = $1 AND "
                            "seq >= $2::bigint AND seq < $3::bigint ORDER BY seq LIMIT 1",
                            values,
                            lengths,
                            formats);
  if (query.rows() == 0) return std::nullopt;
  return std::make_pair(query.Integer(0), query.Blob(1));
}

Found NextSqlite(Transaction& tx, const std::string& owner, std::int64_t from, std::int64_t to) {
  soci::blob blob(tx.sql());
  std::int64_t sequence = 0;
  tx.sql() << "SELECT seq, bytes FROM blob_store WHERE owner = :owner AND seq >= :first AND "
              "seq < :last ORDER BY seq LIMIT 1",
      soci::into(sequence), soci::into(blob), soci::use(owner, "owner"), soci::use(from, "first"),
      soci::use(to, "last");
  if (!tx.sql().got_data()) return std::nullopt;
  Bytes bytes(blob.get_len());
  if (!bytes.empty()) {
    blob.read(0, reinterpret_cast<char*>(bytes.data()), bytes.size());
  }
  return std::make_pair(sequence, std::move(bytes));
}

Found Next(Transaction& tx, const std::string& owner, std::int64_t from, std::int64_t to) {
  return tx.engine() == Engine::kSqlite ? NextSqlite(tx, owner, from, to)
                                        : NextPostgres(tx, owner, from, to);
}

}  // namespace

void Put(Transaction& tx,
         const std::string& owner,
         std::int64_t sequence,
         std::span<const std::byte> bytes) {
  if (tx.engine() == Engine::kPostgresql) {
    PutPostgres(tx, owner, sequence, bytes);
    return;
  }
  if (bytes.empty()) {
    Execute(tx,
            "INSERT INTO blob_store (owner, seq, bytes) VALUES (:owner, :seq, zeroblob(0))",
            {{"owner", owner}, {"seq", sequence}});
    return;
  }
  soci::blob blob(tx.sql());
  blob.write(0, reinterpret_cast<const char*>(bytes.data()), bytes.size());
  tx.sql() << "INSERT INTO blob_store (owner, seq, bytes) VALUES (:owner, :seq, :bytes)",
      soci::use(owner, "owner"), soci::use(sequence, "seq"), soci::use(blob, "bytes");
}

std::optional<Bytes> Get(Transaction& tx, const std::string& owner, std::int64_t sequence) {
  LAB_CHECK(sequence < std::numeric_limits<std::int64_t>::max());
  Found found = Next(tx, owner, sequence, sequence + 1);
  if (!found) return std::nullopt;
  return std::move(found->second);
}

void ForEach(Transaction& tx,
             const std::string& owner,
             std::int64_t from,
             std::int64_t to,
             const std::function<bool(std::int64_t, const Bytes&)>& visit) {
  while (from < to) {
    const Found found = Next(tx, owner, from, to);
    if (!found || !visit(found->first, found->second)) return;
    from = found->first + 1;
  }
}

std::optional<std::int64_t> SequenceAtOrBefore(Transaction& tx,
                                               const std::string& owner,
                                               std::int64_t at) {
  return SelectValue<std::int64_t>(
      tx,
      "SELECT seq FROM blob_store WHERE owner = :owner AND seq <= :at ORDER BY seq DESC LIMIT 1",
      {{"owner", owner}, {"at", at}});
}

void Erase(Transaction& tx, const std::string& owner) {
  DeleteFrom(tx, "blob_store", {{"owner", owner}});
}

}  // namespace faultlab::server::blob_store

#include "server/auth/credentials.h"
#include "server/storage/rows.h"

namespace faultlab::server::credentials {
namespace {

constexpr auto kSignInLives = std::chrono::hours(12);
constexpr auto kDeviceLives = std::chrono::hours(24 * 400);

}  // namespace

bool IsKnownDevice(Transaction& tx, const std::string& login, const std::string& device_hash) {
  return CountRows(tx,
                   "known_device d JOIN account a ON a.id = d.account_id "
                   "WHERE d.token_hash = :hash AND a.login = :login",
                   {{"hash", device_hash}, {"login", login}}) > 0;
}

bool IsKnownNetwork(Transaction& tx, const std::string& login, const std::string& network) {
  return CountRows(tx,
                   "known_device d JOIN account a ON a.id = d.account_id "
                   "WHERE d.network = :network AND a.login = :login",
                   {{"network", network}, {"login", login}}) > 0;
}

void RememberDevice(Transaction& tx,
                    std::int64_t account,
                    const std::string& hash,
                    const std::string& network,
                    WallTime now) {
  Execute(
      tx,
      "INSERT INTO known_device (token_hash, account_id, network, created_ms, used_ms) "
      "VALUES (:hash, :account, :network, :now, :used) "
      "ON CONFLICT (token_hash, account_id) DO UPDATE SET used_ms = excluded.used_ms, "
      "network = excluded.network",
      {{"hash", hash}, {"account", account}, {"network", network}, {"now", now}, {"used", now}});
  Execute(tx,
          "DELETE FROM known_device WHERE used_ms < :old OR (account_id = :account AND "
          "token_hash IN (SELECT token_hash FROM known_device WHERE account_id = :account "
          "ORDER BY used_ms DESC LIMIT 1000 OFFSET 20))",
          {{"old", now - kDeviceLives}, {"account", account}});
}

void AddSignIn(Transaction& tx, const NewSignIn& sign_in, WallTime now) {
  InsertInto(tx,
             "sign_in",
             {{"token_hash", sign_in.token_hash},
              {"account_id", sign_in.account},
              {"csrf", sign_in.csrf},
              {"created_ms", now},
              {"expires_ms", now + kSignInLives},
              {"address", sign_in.address}});
  Execute(tx,
          "DELETE FROM sign_in WHERE expires_ms < :now OR token_hash IN (SELECT token_hash "
          "FROM sign_in WHERE account_id = :account ORDER BY created_ms DESC "
          "LIMIT 1000 OFFSET 200)",
          {{"now", now}, {"account", sign_in.account}});
}

void EndSignIns(Transaction& tx, std::int64_t account, const std::string& but_this) {
  Execute(tx,
          "DELETE FROM sign_in WHERE account_id = :id AND token_hash <> :this",
          {{"id", account}, {"this", but_this}});
  DeleteFrom(tx, "known_device", {{"account_id", account}});
}

void EndKeys(Transaction& tx, std::int64_t account) {
  UpdateWhere(tx, "api_key", {{"revoked", 1}}, {{"account_id", account}});
  DeleteFrom(tx, "calendar_link", {{"account_id", account}});
}

void EndAll(Transaction& tx, std::int64_t account) {
  EndSignIns(tx, account, "");
  EndKeys(tx, account);
  DeleteFrom(tx, "one_time_link", {{"account_id", account}});
  Execute(
      tx, "DELETE FROM external_identity WHERE account_id = :id AND added = 1", {{"id", account}});
}

}  // namespace faultlab::server::credentials

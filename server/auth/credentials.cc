#include "server/auth/credentials.h"

namespace faultlab::server::credentials {
namespace {

using soci::into;
using soci::use;

constexpr auto kSignInLives = std::chrono::hours(12);
constexpr auto kDeviceLives = std::chrono::hours(24 * 400);

}  // namespace

bool IsKnownDevice(Transaction& tx, const std::string& login, const std::string& device_hash) {
  std::int64_t count = 0;
  tx.sql() << "SELECT COUNT(*) FROM known_device d JOIN account a ON a.id = d.account_id "
              "WHERE d.token_hash = :hash AND a.login = :login",
      into(count), use(device_hash, "hash"), use(login, "login");
  return count > 0;
}

bool IsKnownNetwork(Transaction& tx, const std::string& login, const std::string& network) {
  std::int64_t count = 0;
  tx.sql() << "SELECT COUNT(*) FROM known_device d JOIN account a ON a.id = d.account_id "
              "WHERE d.network = :network AND a.login = :login",
      into(count), use(network, "network"), use(login, "login");
  return count > 0;
}

void RememberDevice(Transaction& tx,
                    std::int64_t account,
                    const std::string& hash,
                    const std::string& network,
                    WallTime now) {
  const std::int64_t now_ms = ToMilliseconds(now);
  const std::int64_t old_ms = ToMilliseconds(now - kDeviceLives);
  tx.sql() << "INSERT INTO known_device (token_hash, account_id, network, created_ms, used_ms) "
              "VALUES (:hash, :account, :network, :now, :used) "
              "ON CONFLICT (token_hash, account_id) DO UPDATE SET used_ms = excluded.used_ms, "
              "network = excluded.network",
      use(hash, "hash"), use(account, "account"), use(network, "network"), use(now_ms, "now"),
      use(now_ms, "used");
  tx.sql() << "DELETE FROM known_device WHERE used_ms < :old OR (account_id = :account AND "
              "token_hash IN (SELECT token_hash FROM known_device WHERE account_id = :same "
              "ORDER BY used_ms DESC LIMIT 1000 OFFSET 20))",
      use(old_ms, "old"), use(account, "account"), use(account, "same");
}

void AddSignIn(Transaction& tx, const NewSignIn& sign_in, WallTime now) {
  const std::int64_t now_ms = ToMilliseconds(now);
  const std::int64_t expires_ms = ToMilliseconds(now + kSignInLives);
  tx.sql() << "INSERT INTO sign_in (token_hash, account_id, csrf, created_ms, expires_ms, "
              "address) VALUES (:hash, :account, :csrf, :now, :expires, :address)",
      use(sign_in.token_hash, "hash"), use(sign_in.account, "account"), use(sign_in.csrf, "csrf"),
      use(now_ms, "now"), use(expires_ms, "expires"), use(sign_in.address, "address");
  tx.sql() << "DELETE FROM sign_in WHERE expires_ms < :now OR token_hash IN (SELECT token_hash "
              "FROM sign_in WHERE account_id = :account ORDER BY created_ms DESC "
              "LIMIT 1000 OFFSET 200)",
      use(now_ms, "now"), use(sign_in.account, "account");
}

void EndSignIns(Transaction& tx, std::int64_t account, const std::string& but_this) {
  tx.sql() << "DELETE FROM sign_in WHERE account_id = :id AND token_hash <> :this",
      use(account, "id"), use(but_this, "this");
  tx.sql() << "DELETE FROM known_device WHERE account_id = :id", use(account, "id");
}

void EndKeys(Transaction& tx, std::int64_t account) {
  tx.sql() << "UPDATE api_key SET revoked = 1 WHERE account_id = :id", use(account, "id");
  tx.sql() << "DELETE FROM calendar_link WHERE account_id = :id", use(account, "id");
}

void EndAll(Transaction& tx, std::int64_t account) {
  EndSignIns(tx, account, "");
  EndKeys(tx, account);
  tx.sql() << "DELETE FROM one_time_link WHERE account_id = :id", use(account, "id");
  tx.sql() << "DELETE FROM external_identity WHERE account_id = :id AND added = 1",
      use(account, "id");
}

}  // namespace faultlab::server::credentials

#include "server/lti/tool_key.h"

#include <boost/json.hpp>

#include "server/storage/ids.h"
#include "server/storage/rows.h"
#include "server/storage/turns.h"

namespace faultlab::server::lti {
namespace {

namespace json = boost::json;

struct KeyRow {
  std::int64_t id = 1;
  std::string kid;
  std::string pem;
  WallTime created{};
};

template <typename Visit>
void Fields(KeyRow& row, Visit&& visit) {
  visit("id", row.id);
  visit("kid", row.kid);
  visit("pem", row.pem);
  visit("created_ms", row.created);
}

}  // namespace

core::Result<ToolKey> ToolKey::Open(Database& database, WallTime now) {
  TRY(const auto row, database.Write(Durability::kPromise, [&](Transaction& tx) {
    TakeTurn(tx, "lti_key");
    if (auto known = SelectRow<KeyRow>(tx, "lti_key WHERE id = 1")) return std::move(*known);
    KeyRow fresh;
    fresh.kid = NewId("key");
    fresh.pem = oidc::SigningKey::Make().Pem();
    fresh.created = now;
    PutRow(tx, "lti_key", fresh);
    return fresh;
  }));
  TRY(auto key, oidc::SigningKey::Read(row.pem));
  return ToolKey(row.kid, std::move(key));
}

std::string ToolKey::KeySet() const {
  return json::serialize(json::object{{"keys", json::array{key_.PublicKey(kid_)}}});
}

}  // namespace faultlab::server::lti

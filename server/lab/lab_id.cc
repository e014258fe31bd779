#include "server/lab/lab_id.h"

#include <optional>
#include <span>
#include <string_view>

#include "server/storage/blob_store.h"
#include "server/storage/ids.h"

namespace faultlab::server::lab {
namespace {

std::optional<std::string> Stored(Transaction& tx, const std::string& owner) {
  const std::optional<Bytes> bytes = blob_store::Get(tx, owner, 0);
  if (!bytes) return std::nullopt;
  return std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size());
}

/// The value stored under `owner`. The first server that asks makes it.
core::Result<std::string> Shared(Database& database,
                                 const std::string& owner,
                                 std::string_view prefix) {
  using Text = core::Result<std::string>;
  const auto get_or_make = [&](Transaction& tx) -> Text {
    if (const auto stored = Stored(tx, owner)) return *stored;
    const std::string made = NewId(prefix);
    blob_store::Put(tx, owner, 0, std::as_bytes(std::span(made)));
    return made;
  };
  Text text = database.Write(Durability::kPromise, get_or_make);
  // When two servers start together, the write of the second fails; its second try finds the value.
  if (!text) text = database.Write(Durability::kPromise, get_or_make);
  return text;
}

}  // namespace

core::Result<std::string> LabId(Database& database) {
  return Shared(database, "lab_id", "lab");
}

core::Result<std::string> HopSecret(Database& database) {
  return Shared(database, "hop_secret", "hop");
}

core::Result<std::string> LoginSecret(Database& database) {
  return Shared(database, "login_secret", "login");
}

}  // namespace faultlab::server::lab

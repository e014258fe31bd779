#include "server/lab/lab_id.h"

#include <cstddef>
#include <optional>
#include <span>

#include "server/storage/blob_store.h"
#include "server/storage/ids.h"

namespace faultlab::server::lab {
namespace {

const std::string kOwner = "lab_id";

std::optional<std::string> Stored(Transaction& tx) {
  const std::optional<Bytes> bytes = blob_store::Get(tx, kOwner, 0);
  if (!bytes) return std::nullopt;
  return std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size());
}

}  // namespace

core::Result<std::string> LabId(Database& database) {
  using Id = core::Result<std::string>;
  const auto get_or_make = [](Transaction& tx) -> Id {
    if (const auto stored = Stored(tx)) return *stored;
    const std::string made = NewId("lab");
    blob_store::Put(tx, kOwner, 0, std::as_bytes(std::span(made)));
    return made;
  };
  Id id = database.Write(Durability::kPromise, get_or_make);
  // Two servers that start together make it once: the second one finds it.
  if (!id) id = database.Write(Durability::kPromise, get_or_make);
  return id;
}

}  // namespace faultlab::server::lab

#include "server/storage/picture_store.h"

#include <soci/soci.h>

#include <optional>
#include <span>
#include <utility>

#include "server/storage/blob_store.h"
#include "server/storage/not_yours.h"
#include "server/storage/recording_store.h"

namespace faultlab::server {
namespace {

using core::Done;
using core::Error;
using core::ErrorCode;
using soci::into;
using soci::use;

std::string BlobOwner(const std::string& run) {
  return "pictures:" + run;
}

int CountOf(Transaction& tx, const std::string& run) {
  int count = 0;
  tx.sql() << "SELECT COUNT(*) FROM recording_picture WHERE recording_id = :id", into(count),
      use(run, "id");
  return count;
}

bool Fits(int count, std::string_view why) {
  return count < (why == "end" ? PictureStore::kOfRunMax : PictureStore::kOfRunMax - 1);
}

/// On PostgreSQL a deletion of the recording waits until the commit.
bool LockRecording(Transaction& tx, const std::string& run) {
  std::string id;
  std::string query = "SELECT id FROM recording WHERE id = :id";
  if (tx.engine() == Engine::kPostgresql) query += " FOR UPDATE";
  tx.sql() << query, into(id), use(run, "id");
  return tx.sql().got_data();
}

}  // namespace

core::Status PictureStore::Add(const std::string& run,
                               StoredPicture picture,
                               std::string_view bytes) {
  return database_.Write(Durability::kTelemetry, [&](Transaction& tx) -> core::Status {
    if (!LockRecording(tx, run)) return NotYours();
    int same = 0;
    tx.sql() << "SELECT COUNT(*) FROM recording_picture WHERE recording_id = :id AND "
                "sample_index = :sample AND why = :why",
        into(same), use(run, "id"), use(picture.sample, "sample"), use(picture.why, "why");
    const int count = CountOf(tx, run);
    if (same > 0 || !Fits(count, picture.why)) {
      return Error{ErrorCode::kConflict, "this recording has its pictures already", "", "internal"};
    }
    const int index = count + 1;
    const auto size_bytes = static_cast<std::int64_t>(bytes.size());
    tx.sql() << "INSERT INTO recording_picture (recording_id, picture, sample_index, why, "
                "content_type, size_bytes) VALUES (:id, :picture, :sample, :why, :type, :size)",
        use(run, "id"), use(index, "picture"), use(picture.sample, "sample"),
        use(picture.why, "why"), use(picture.content_type, "type"), use(size_bytes, "size");
    blob_store::Put(tx, BlobOwner(run), index, std::as_bytes(std::span(bytes)));
    return Done{};
  });
}

core::Result<bool> PictureStore::HasRoom(const std::string& run, std::string_view why) {
  return database_.Read(
      [&](Transaction& tx) -> core::Result<bool> { return Fits(CountOf(tx, run), why); });
}

core::Result<std::vector<StoredPicture>> PictureStore::List(const std::string& run) {
  using Pictures = std::vector<StoredPicture>;
  return database_.Read([&](Transaction& tx) {
    StoredPicture picture;
    soci::statement query =
        (tx.sql().prepare << "SELECT picture, sample_index, why, content_type, size_bytes "
                             "FROM recording_picture WHERE recording_id = :id ORDER BY picture",
         into(picture.index),
         into(picture.sample),
         into(picture.why),
         into(picture.content_type),
         into(picture.size_bytes),
         use(run, "id"));
    query.execute(false);
    Pictures pictures;
    while (query.fetch()) pictures.push_back(picture);
    return pictures;
  });
}

core::Result<std::string> PictureStore::Load(const std::string& run, int index) {
  return database_.Read([&](Transaction& tx) -> core::Result<std::string> {
    const std::optional<Bytes> bytes = blob_store::Get(tx, BlobOwner(run), index);
    if (!bytes) return NotYours();
    return std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size());
  });
}

void EraseRecordingBlobs(Transaction& tx, const std::string& run) {
  blob_store::Erase(tx, RecordingBlobs(run));
  blob_store::Erase(tx, BlobOwner(run));
}

}  // namespace faultlab::server

#include "server/storage/picture_store.h"

#include <optional>
#include <span>

#include "server/storage/blob_store.h"
#include "server/storage/not_yours.h"
#include "server/storage/recording_store.h"
#include "server/storage/rows.h"

namespace faultlab::server {

template <typename Visit>
void Fields(StoredPicture& picture, Visit&& visit) {
  visit("picture", picture.index);
  visit("sample_index", picture.sample);
  visit("why", picture.why);
  visit("content_type", picture.content_type);
  visit("size_bytes", picture.size_bytes);
}

namespace {

using core::Done;
using core::Error;
using core::ErrorCode;

std::string BlobOwner(const std::string& run) {
  return "pictures:" + run;
}

std::int64_t CountOf(Transaction& tx, const std::string& run) {
  return CountRows(tx, "recording_picture WHERE recording_id = :id", {{"id", run}});
}

bool Fits(std::int64_t count, std::string_view why) {
  return count < (why == "end" ? PictureStore::kOfRunMax : PictureStore::kOfRunMax - 1);
}

/// On PostgreSQL a deletion of the recording waits until the commit.
bool LockRecording(Transaction& tx, const std::string& run) {
  std::string query = "SELECT id FROM recording WHERE id = :id";
  if (tx.engine() == Engine::kPostgresql) query += " FOR UPDATE";
  return SelectValue<std::string>(tx, query, {{"id", run}}).has_value();
}

}  // namespace

core::Status PictureStore::Add(const std::string& run,
                               StoredPicture picture,
                               std::string_view bytes) {
  return database_.Write(Durability::kTelemetry, [&](Transaction& tx) -> core::Status {
    if (!LockRecording(tx, run)) return NotYours();
    const std::int64_t same =
        CountRows(tx,
                  "recording_picture WHERE recording_id = :id AND "
                  "sample_index = :sample AND why = :why",
                  {{"id", run}, {"sample", picture.sample}, {"why", picture.why}});
    const std::int64_t count = CountOf(tx, run);
    if (same > 0 || !Fits(count, picture.why)) {
      return Error{ErrorCode::kConflict, "this recording has its pictures already", "", "internal"};
    }
    const std::int64_t index = count + 1;
    InsertInto(tx,
               "recording_picture",
               {{"recording_id", run},
                {"picture", index},
                {"sample_index", picture.sample},
                {"why", picture.why},
                {"content_type", picture.content_type},
                {"size_bytes", static_cast<std::int64_t>(bytes.size())}});
    blob_store::Put(tx, BlobOwner(run), index, std::as_bytes(std::span(bytes)));
    return Done{};
  });
}

core::Result<bool> PictureStore::HasRoom(const std::string& run, std::string_view why) {
  return database_.Read(
      [&](Transaction& tx) -> core::Result<bool> { return Fits(CountOf(tx, run), why); });
}

core::Result<std::vector<StoredPicture>> PictureStore::List(const std::string& run) {
  return database_.Read([&](Transaction& tx) {
    return SelectRows<StoredPicture>(
        tx, "recording_picture WHERE recording_id = :id ORDER BY picture", {{"id", run}});
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

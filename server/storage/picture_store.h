#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/types/result.h"
#include "server/storage/database.h"

namespace faultlab::server {

/// A picture that belongs to a recording, without its bytes.
struct StoredPicture {
  int index = 0;            ///< 1, 2, .. within its recording
  std::int64_t sample = 0;  ///< index of the sample at which it was asked for
  std::string why;          ///< "fault", "detection" or "end"
  std::string content_type;
  std::int64_t size_bytes = 0;
};

/// The pictures of recordings: a row each, its bytes in the blob store. They are deleted together
/// with their recording. Thread-safe, stateless.
class PictureStore {
 public:
  explicit PictureStore(Database& database) : database_(database) {}

  static constexpr int kOfRunMax = 12;  ///< the last place is kept for the end of the run

  /// Appends a picture to a recording, running or ended; the store chooses its index and size.
  /// kNotFound: there is no such recording (any more). kConflict: it has its pictures already, or
  /// this one.
  core::Status Add(const std::string& run, StoredPicture picture, std::string_view bytes);
  /// Whether Add would take one more for this reason.
  core::Result<bool> HasRoom(const std::string& run, std::string_view why);
  core::Result<std::vector<StoredPicture>> List(const std::string& run);
  /// The bytes. kNotFound.
  core::Result<std::string> Load(const std::string& run, int index);

 private:
  Database& database_;
};

/// Deletes the samples and pictures of a recording from the blob store, in the caller's
/// transaction: no foreign key refers to blobs. Throws what the database throws.
void EraseRecordingBlobs(Transaction& tx, const std::string& run);

}  // namespace faultlab::server

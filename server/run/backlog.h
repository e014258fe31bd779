#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/types/result.h"
#include "core/types/sample.h"
#include "server/storage/recording_store.h"

namespace faultlab::server {

/// What a run has recorded while the database was away, in a file that outlives the process (not a
/// power cut). First in, first out. One thread at a time.
///
/// The file: "FLBL", then of each part u8 kind, u32 length, u32 CRC-32, and the bytes: a chunk
/// (chunk_codec.h), or JSON.
class Backlog {
 public:
  /// Three hours at 100 Hz.
  static constexpr std::int64_t kBytesMax = 64 << 20;

  /// One of the members has a value.
  struct Part {
    std::vector<core::Sample> samples{};
    std::vector<RecordedEvent> events{};
    std::int64_t events_before = 0;  ///< number of events of the run before these
    std::optional<RunEnd> end{};
  };

  /// Makes the folder and the file `run`.backlog, or opens it.
  static core::Result<Backlog> Open(const std::string& folder, const std::string& run);
  /// The runs that have such a file.
  static std::vector<std::string> RunsIn(const std::string& folder);

  Backlog(Backlog&& other) noexcept;
  Backlog& operator=(Backlog&& other) noexcept;
  ~Backlog();  ///< the file stays

  /// kUnavailable when the disk or the backlog is full; then nothing is appended.
  core::Status Append(const Part& part);
  /// The oldest part that was not taken; nullopt when there is none, and where the file is torn.
  std::optional<Part> Front() const;
  void Pop();
  bool empty() const { return taken_ >= size_; }
  void Remove();

 private:
  Backlog(std::string path, int fd, std::int64_t size)
      : path_(std::move(path)), fd_(fd), size_(size) {}
  std::optional<std::string> Read(std::int64_t at, std::size_t bytes) const;
  core::Status Refuse(int error) const;

  std::string path_;
  int fd_ = -1;
  std::int64_t size_ = 0;
  std::int64_t taken_ = 0;  ///< bytes
};

/// Stores what former processes of this server could not store, and removes their files. Their
/// runs must have been marked as interrupted. A file that cannot be stored stays.
/// @returns an Error while the database is busy or away
core::Status StoreBacklogs(const std::string& folder,
                           RecordingStore& store,
                           const std::function<void(std::string_view)>& log);

}  // namespace faultlab::server

#include "server/run/backlog.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <boost/crc.hpp>
#include <boost/json.hpp>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

#include "server/json/list_of.h"
#include "server/storage/chunk_codec.h"
#include "server/storage/database_error.h"

namespace faultlab::server {
namespace {

namespace fs = std::filesystem;
namespace json = boost::json;

constexpr std::string_view kMagic = "FLBL";
constexpr const char* kExtension = ".backlog";
constexpr std::size_t kHeadBytes = 9;

enum Kind : std::uint8_t { kSamples = 1, kEvents = 2, kEnd = 3 };

struct Head {
  std::uint8_t kind = 0;
  std::uint32_t length = 0;
  std::uint32_t crc = 0;
};

std::string Packed(const Head& head) {
  std::string out(kHeadBytes, '\0');
  out[0] = static_cast<char>(head.kind);
  std::memcpy(out.data() + 1, &head.length, 4);
  std::memcpy(out.data() + 5, &head.crc, 4);
  return out;
}

Head Unpacked(const std::string& bytes) {
  Head head;
  head.kind = static_cast<std::uint8_t>(bytes[0]);
  std::memcpy(&head.length, bytes.data() + 1, 4);
  std::memcpy(&head.crc, bytes.data() + 5, 4);
  return head;
}

std::uint32_t CrcOf(std::string_view bytes) {
  boost::crc_32_type crc;
  crc.process_bytes(bytes.data(), bytes.size());
  return crc.checksum();
}

std::string BytesOf(const Backlog::Part& part, Kind& kind) {
  if (!part.samples.empty()) {
    kind = kSamples;
    const Bytes chunk = EncodeChunk(part.samples);
    return {reinterpret_cast<const char*>(chunk.data()), chunk.size()};
  }
  if (part.end) {
    kind = kEnd;
    return json::serialize(
        json::object{{"state", Name(part.end->state)}, {"ended_ms", ToMilliseconds(part.end->at)}});
  }
  kind = kEvents;
  const auto event_to_json = [](const RecordedEvent& event) {
    return json::array{event.index, event.kind, event.json};
  };
  return json::serialize(
      json::object{{"before", part.events_before}, {"events", ListOf(part.events, event_to_json)}});
}

/// Throws on bytes that no BytesOf has made.
Backlog::Part PartOf(std::uint8_t kind, const std::string& bytes) {
  Backlog::Part part;
  if (kind == kSamples) {
    const auto* data = reinterpret_cast<const std::byte*>(bytes.data());
    auto samples = DecodeChunk({data, bytes.size()});
    if (!samples.ok()) throw std::runtime_error(samples.error().message);
    part.samples = std::move(samples).value();
    return part;
  }
  const json::object object = json::parse(bytes).as_object();
  if (kind == kEnd) {
    const auto state = ParseRunState(object.at("state").as_string());
    part.end = {state.value(), FromMilliseconds(object.at("ended_ms").as_int64())};
    return part;
  }
  part.events_before = object.at("before").as_int64();
  for (const json::value& each : object.at("events").as_array()) {
    const json::array& event = each.as_array();
    part.events.push_back({event.at(0).as_int64(),
                           std::string(event.at(1).as_string()),
                           std::string(event.at(2).as_string())});
  }
  return part;
}

bool WriteAll(int fd, std::int64_t at, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t wrote = ::pwrite(fd, bytes.data(), bytes.size(), at);
    if (wrote < 0 && errno == EINTR) continue;
    if (wrote <= 0) return false;
    at += wrote;
    bytes.remove_prefix(static_cast<std::size_t>(wrote));
  }
  return true;
}

core::Status StoreBacklog(Backlog& backlog, const std::string& run, RecordingStore& store) {
  std::optional<RunEnd> end;
  for (; auto part = backlog.Front(); backlog.Pop()) {
    core::Status stored = core::Done{};
    if (part->end) {
      end = part->end;
    } else if (!part->samples.empty()) {
      stored = store.AppendLate(run, part->samples);
    } else {
      stored = store.AppendEvents(run, part->events, part->events_before);
    }
    if (!stored.ok()) return stored;
  }
  return store.EndLate(run, end);
}

}  // namespace

core::Result<Backlog> Backlog::Open(const std::string& folder, const std::string& run) {
  std::error_code ec;
  fs::create_directories(folder, ec);
  const std::string path = (fs::path(folder) / (run + kExtension)).string();
  const int fd = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  struct stat about {};
  Backlog backlog(path, fd, 0);
  if (fd < 0 || ::fstat(fd, &about) != 0) return backlog.Refuse(errno).error();
  backlog.size_ = about.st_size;
  if (backlog.size_ == 0) {
    if (!WriteAll(fd, 0, kMagic)) {
      const int error = errno;
      backlog.Remove();
      return backlog.Refuse(error).error();
    }
    backlog.size_ = static_cast<std::int64_t>(kMagic.size());
  } else if (backlog.Read(0, kMagic.size()) != kMagic) {
    return core::Error{core::ErrorCode::kUnavailable,
                       path + " is not what faultlab wrote",
                       "",
                       "recording_failed"};
  }
  backlog.taken_ = static_cast<std::int64_t>(kMagic.size());
  return backlog;
}

std::vector<std::string> Backlog::RunsIn(const std::string& folder) {
  std::vector<std::string> runs;
  std::error_code ec;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ec)) {
    if (entry.path().extension() == kExtension) runs.push_back(entry.path().stem().string());
  }
  std::ranges::sort(runs);
  return runs;
}

Backlog::Backlog(Backlog&& other) noexcept {
  *this = std::move(other);
}

Backlog& Backlog::operator=(Backlog&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(fd_, other.fd_);
  std::swap(size_, other.size_);
  std::swap(taken_, other.taken_);
  return *this;
}

Backlog::~Backlog() {
  if (fd_ >= 0) ::close(fd_);
}

core::Status Backlog::Refuse(int error) const {
  return core::Error{core::ErrorCode::kUnavailable,
                     "cannot write " + path_ + ": " + std::strerror(error),
                     "",
                     "disk_full"};
}

core::Status Backlog::Append(const Part& part) {
  Head head;
  Kind kind = kEvents;
  const std::string bytes = BytesOf(part, kind);
  head.kind = kind;
  head.length = static_cast<std::uint32_t>(bytes.size());
  head.crc = CrcOf(bytes);
  const std::string whole = Packed(head) + bytes;
  const auto added = static_cast<std::int64_t>(whole.size());
  if (size_ + added > kBytesMax && !part.end) return Refuse(EFBIG);
  if (!WriteAll(fd_, size_, whole)) {
    const int error = errno == 0 ? ENOSPC : errno;
    (void)!::ftruncate(fd_, size_);
    return Refuse(error);
  }
  size_ += added;
  return core::Done{};
}

std::optional<std::string> Backlog::Read(std::int64_t at, std::size_t bytes) const {
  std::string out(bytes, '\0');
  std::size_t got = 0;
  while (got < bytes) {
    const ssize_t read =
        ::pread(fd_, out.data() + got, bytes - got, at + static_cast<std::int64_t>(got));
    if (read < 0 && errno == EINTR) continue;
    if (read <= 0) return std::nullopt;
    got += static_cast<std::size_t>(read);
  }
  return out;
}

std::optional<Backlog::Part> Backlog::Front() const {
  const auto head_bytes = Read(taken_, kHeadBytes);
  if (!head_bytes) return std::nullopt;
  const Head head = Unpacked(*head_bytes);
  if (taken_ + static_cast<std::int64_t>(kHeadBytes + head.length) > size_) return std::nullopt;
  const auto bytes = Read(taken_ + static_cast<std::int64_t>(kHeadBytes), head.length);
  if (!bytes || CrcOf(*bytes) != head.crc) return std::nullopt;
  try {
    return PartOf(head.kind, *bytes);
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

void Backlog::Pop() {
  const auto head = Read(taken_, kHeadBytes);
  taken_ = head ? taken_ + static_cast<std::int64_t>(kHeadBytes + Unpacked(*head).length) : size_;
}

void Backlog::Remove() {
  ::unlink(path_.c_str());
}

core::Status StoreBacklogs(const std::string& folder,
                           RecordingStore& store,
                           const std::function<void(std::string_view)>& log) {
  for (const std::string& run : Backlog::RunsIn(folder)) {
    auto backlog = Backlog::Open(folder, run);
    const core::Status stored =
        backlog ? StoreBacklog(backlog.value(), run, store) : core::Status(backlog.error());
    const bool gone = !stored.ok() && stored.error().code == core::ErrorCode::kNotFound;
    if (stored.ok() || gone) {
      log("run " + run + (gone ? " is deleted: its backlog too" : ": its backlog is stored"));
      backlog.value().Remove();
    } else if (MayPass(stored.error())) {
      return stored;
    } else {
      log("run " + run + ": its backlog stays: " + stored.error().message);
    }
  }
  return core::Done{};
}

}  // namespace faultlab::server

#include "server/csv/file_io.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <limits>

namespace faultlab::server {
namespace {

using core::Done;
using core::Error;
using core::ErrorCode;
using core::Result;
using core::Status;

class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (fd_ > STDERR_FILENO) {
      ::close(fd_);
    }
  }
  int get() const { return fd_; }
  /// Closing can report an error that writing did not (a full network disk).
  bool Close() {
    const int fd = fd_;
    fd_ = -1;
    return fd <= STDERR_FILENO || ::close(fd) == 0;
  }

 private:
  int fd_;
};

std::string Reason() {
  return std::strerror(errno);
}

Error TooLarge(std::string_view name, std::size_t bytes_max) {
  return {ErrorCode::kTooLarge,
          std::string(name) + ": more than " + std::to_string(bytes_max >> 20) +
              " MiB of text; split the recording",
          "",
          "file_too_large",
          {{"most", std::to_string(bytes_max)}}};
}

bool WriteAll(int fd, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(fd, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) {
      continue;
    }
    if (written <= 0) {
      return false;
    }
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

Error WriteError(const std::string& path, const std::string& reason) {
  return {ErrorCode::kUnavailable, "cannot write " + path + ": " + reason, "", "disk_refuses"};
}

Status WriteInPlace(const std::string& path, std::string_view bytes) {
  Descriptor file(path == "-" ? STDOUT_FILENO
                              : ::open(path.c_str(), O_WRONLY | O_CLOEXEC | O_NOCTTY));
  if (file.get() < 0 || !WriteAll(file.get(), bytes) || !file.Close()) {
    return WriteError(path == "-" ? "the standard output" : path, Reason());
  }
  return Done{};
}

Status WriteThroughRename(const std::string& path, std::string_view bytes) {
  std::string temporary = path + ".part-XXXXXX";
  Descriptor file(::mkostemp(temporary.data(), O_CLOEXEC));
  if (file.get() < 0) {
    return WriteError(path, Reason());
  }
  const mode_t mask = ::umask(0);
  ::umask(mask);
  const bool written = ::fchmod(file.get(), 0666 & ~mask) == 0 && WriteAll(file.get(), bytes) &&
                       ::fsync(file.get()) == 0 && file.Close() &&
                       ::rename(temporary.c_str(), path.c_str()) == 0;
  if (!written) {
    const std::string reason = Reason();
    ::unlink(temporary.c_str());
    return WriteError(path, reason);
  }
  return Done{};
}

}  // namespace

bool IsGzipName(std::string_view path) {
  return path.ends_with(".gz");
}

Result<std::string> ReadFile(const std::string& path, std::size_t bytes_max) {
  const bool standard_input = path == "-";
  const std::string name = standard_input ? "standard input" : path;
  Descriptor file(standard_input ? STDIN_FILENO
                                 : ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOCTTY));
  if (file.get() < 0) {
    return Error{errno == ENOENT ? ErrorCode::kNotFound : ErrorCode::kUnavailable,
                 "cannot read " + name + ": " + Reason(),
                 ""};
  }
  std::string bytes;
  struct stat info {};
  if (::fstat(file.get(), &info) == 0 && S_ISREG(info.st_mode)) {
    if (static_cast<std::uint64_t>(info.st_size) > bytes_max) {
      return TooLarge(name, bytes_max);
    }
    bytes.reserve(static_cast<std::size_t>(info.st_size));
  }
  std::array<char, 1 << 16> chunk;
  for (;;) {
    const ssize_t got = ::read(file.get(), chunk.data(), chunk.size());
    if (got < 0 && errno == EINTR) {
      continue;
    }
    if (got < 0) {
      return Error{
          ErrorCode::kUnavailable, "cannot read " + name + ": " + Reason(), "", "disk_refuses"};
    }
    if (got == 0) {
      break;
    }
    if (bytes.size() + static_cast<std::size_t>(got) > bytes_max) {
      return TooLarge(name, bytes_max);
    }
    bytes.append(chunk.data(), static_cast<std::size_t>(got));
  }
  return IsGzipName(path) ? Gunzip(bytes, name, bytes_max) : Result<std::string>(std::move(bytes));
}

Status WriteFile(const std::string& path, std::string_view bytes) {
  std::string compressed;
  if (IsGzipName(path)) {
    compressed = Gzip(bytes);
    bytes = compressed;
  }
  struct stat info {};
  const bool exists = path != "-" && ::stat(path.c_str(), &info) == 0;
  if (exists && S_ISDIR(info.st_mode)) {
    return WriteError(path, "it is a directory");
  }
  if (path == "-" || (exists && !S_ISREG(info.st_mode))) {
    return WriteInPlace(path, bytes);
  }
  return WriteThroughRename(path, bytes);
}

Result<std::string> Gunzip(std::string_view compressed,
                           std::string_view name,
                           std::size_t bytes_max) {
  const Error damaged = {ErrorCode::kInvalid,
                         std::string(name) + ": damaged or cut gzip data; copy the file again",
                         "",
                         "gzip_damaged"};
  z_stream stream{};
  constexpr int kGzipOnly = 16 + MAX_WBITS;
  LAB_CHECK(::inflateInit2(&stream, kGzipOnly) == Z_OK);
  std::string bytes;
  std::array<char, 1 << 16> chunk;
  int code = Z_OK;
  bool member_complete = false;  // bytes after a complete member must be another member
  do {
    if (stream.avail_in == 0) {
      const std::size_t part = std::min<std::size_t>(compressed.size(), 1U << 30);
      // zlib does not write to its input; its C interface lacks the const.
      stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(compressed.data()));
      stream.avail_in = static_cast<uInt>(part);
      compressed.remove_prefix(part);
    }
    stream.next_out = reinterpret_cast<Bytef*>(chunk.data());
    stream.avail_out = static_cast<uInt>(chunk.size());
    code = ::inflate(&stream, Z_NO_FLUSH);
    bytes.append(chunk.data(), chunk.size() - stream.avail_out);
    member_complete = code == Z_STREAM_END;
    if (member_complete && stream.avail_in > 0) {  // a file may hold several members
      code = ::inflateReset(&stream);
    }
  } while (code == Z_OK && bytes.size() <= bytes_max &&
           (stream.avail_in > 0 || stream.avail_out == 0 || !compressed.empty()));
  ::inflateEnd(&stream);
  if (bytes.size() > bytes_max) {
    return TooLarge(name, bytes_max);
  }
  if (!member_complete) {
    return damaged;
  }
  return bytes;
}

std::string Gzip(std::string_view bytes) {
  LAB_CHECK(bytes.size() < std::numeric_limits<uInt>::max(), bytes.size());
  z_stream stream{};
  constexpr int kGzip = 16 + MAX_WBITS;
  constexpr int kMemoryLevel = 8;
  LAB_CHECK(::deflateInit2(
                &stream, Z_BEST_SPEED + 5, Z_DEFLATED, kGzip, kMemoryLevel, Z_DEFAULT_STRATEGY) ==
            Z_OK);
  std::string out(::deflateBound(&stream, static_cast<uLong>(bytes.size())), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  const int code = ::deflate(&stream, Z_FINISH);
  LAB_CHECK(code == Z_STREAM_END, code);
  out.resize(stream.total_out);
  ::deflateEnd(&stream);
  return out;
}

}  // namespace faultlab::server

#include "hardware/device/byte_stream.h"

#include <asm/termbits.h>
#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "hardware/io_error.h"

namespace faultlab::hardware {
namespace {

std::string Why() {
  return std::strerror(errno);
}

/// More than the buffers of a line hold of an earlier conversation.
constexpr std::size_t kFlushedMax = 16 << 20;

/// A descriptor that does not block.
class DescriptorStream : public ByteStream {
 public:
  DescriptorStream(int descriptor, std::string name)
      : descriptor_(descriptor), name_(std::move(name)) {}
  ~DescriptorStream() override { close(descriptor_); }
  DescriptorStream(const DescriptorStream&) = delete;
  DescriptorStream& operator=(const DescriptorStream&) = delete;

  void Write(std::span<const std::uint8_t> bytes) override {
    while (!bytes.empty()) {
      const ssize_t written = Send(bytes);
      if (written > 0) {
        bytes = bytes.subspan(static_cast<std::size_t>(written));
      } else if (errno != EINTR) {
        throw IoError(errno == EAGAIN ? name_ + " takes no more bytes: is the device alive?"
                                      : name_ + " cannot be written: " + Why());
      }
    }
  }

  std::size_t Read(std::span<std::uint8_t> bytes) override {
    const ssize_t size = read(descriptor_, bytes.data(), bytes.size());
    if (size > 0) return static_cast<std::size_t>(size);
    if (size == 0) throw IoError(name_ + " was closed by the other side");
    if (errno == EAGAIN || errno == EINTR) return 0;
    throw IoError(name_ + " cannot be read: " + Why());
  }

  void Flush() override {
    std::array<std::uint8_t, 4096> old{};
    for (std::size_t taken = 0; const std::size_t size = Read(old); taken += size) {
      if (taken > kFlushedMax) throw IoError(name_ + " is flooded by the device");
    }
  }

 protected:
  int descriptor() const { return descriptor_; }
  const std::string& name() const { return name_; }
  virtual ssize_t Send(std::span<const std::uint8_t> bytes) = 0;

 private:
  const int descriptor_;
  const std::string name_;
};

class SerialLine final : public DescriptorStream {
 public:
  using DescriptorStream::DescriptorStream;

  void Configure(int baud) {
    termios2 settings{};
    if (ioctl(descriptor(), TCGETS2, &settings) != 0) {
      throw IoError(name() + " is no serial line: " + Why());
    }
    settings.c_iflag = IGNBRK;
    settings.c_oflag = 0;
    settings.c_lflag = 0;
    settings.c_cflag = CS8 | CREAD | CLOCAL | BOTHER;
    settings.c_ispeed = settings.c_ospeed = static_cast<speed_t>(baud);
    settings.c_cc[VMIN] = 1;  // nothing there is EAGAIN, the end of the line is 0
    settings.c_cc[VTIME] = 0;
    if (ioctl(descriptor(), TCSETS2, &settings) != 0) {
      throw IoError(name() + " does not take " + std::to_string(baud) + " baud: " + Why());
    }
  }

  void Flush() override {
    ioctl(descriptor(), TCFLSH, TCIOFLUSH);
    DescriptorStream::Flush();
  }

 private:
  ssize_t Send(std::span<const std::uint8_t> bytes) override {
    return write(descriptor(), bytes.data(), bytes.size());
  }
};

class TcpLine final : public DescriptorStream {
 public:
  using DescriptorStream::DescriptorStream;

 private:
  ssize_t Send(std::span<const std::uint8_t> bytes) override {
    return send(descriptor(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
  }
};

/// @returns a connected descriptor, or -1 with errno.
int ConnectTo(const addrinfo& address, int patience_ms) {
  const int made = socket(address.ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (made < 0) return -1;
  if (connect(made, address.ai_addr, address.ai_addrlen) != 0) {
    pollfd wait{.fd = made, .events = POLLOUT, .revents = 0};
    int error = errno;
    socklen_t size = sizeof error;
    if (error == EINPROGRESS) {
      if (poll(&wait, 1, patience_ms) > 0) {
        getsockopt(made, SOL_SOCKET, SO_ERROR, &error, &size);
      } else {
        error = ETIMEDOUT;
      }
    }
    if (error != 0) {
      close(made);
      errno = error;
      return -1;
    }
  }
  const int on = 1;
  setsockopt(made, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  return made;
}

}  // namespace

std::unique_ptr<ByteStream> OpenSerialLine(const std::string& path, int baud) {
  const int descriptor = open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) {
    throw IoError(path + " cannot be opened: " + Why() +
                  (errno == EACCES ? " (is the user in the group dialout?)" : ""));
  }
  auto line = std::make_unique<SerialLine>(descriptor, path);
  line->Configure(baud);
  return line;
}

std::unique_ptr<ByteStream> OpenTcpLine(const std::string& host,
                                        const std::string& port,
                                        int patience_ms) {
  const std::string name = host + ":" + port;
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (const int error = getaddrinfo(host.c_str(), port.c_str(), &hints, &found); error != 0) {
    throw IoError(name + " is not known: " + gai_strerror(error));
  }
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> addresses(found, freeaddrinfo);
  int descriptor = -1;
  for (const addrinfo* each = found; each != nullptr && descriptor < 0; each = each->ai_next) {
    descriptor = ConnectTo(*each, patience_ms);
  }
  if (descriptor < 0) throw IoError(name + " cannot be reached: " + Why());
  return std::make_unique<TcpLine>(descriptor, name);
}

}  // namespace faultlab::hardware

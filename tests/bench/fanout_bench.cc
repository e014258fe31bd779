// The cost of a live viewer: the stream hub and a bare loop of send(), in one run, on the same
// machine, with the same frames and the same clients.
//   fanout_bench [VIEWERS] [FRAMES_PER_S] [SECONDS]      default 1000 20 10
// The server side is this process, pinned to core 0; the clients are a forked process on core 1.
// Latency is from the moment a frame is published to the moment its bytes are read.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sched.h>
#include <sys/epoll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "server/net/websocket.h"
#include "server/stream/stream_hub.h"

namespace faultlab::server {
namespace {

using SteadyClock = std::chrono::steady_clock;

struct Load {
  int viewers = 1000;
  int frames_per_s = 20;
  int seconds = 10;
  int rows() const { return std::max(1, 100 / frames_per_s); }
  int frames() const { return frames_per_s * seconds; }
};

struct Latency {
  double p50_ms = 0.0;
  double p99_ms = 0.0;
  double max_ms = 0.0;
  std::uint64_t frames = 0;
};

struct Cost {
  double core_percent = 0.0;
  double us_per_frame = 0.0;
  double kb_per_viewer = 0.0;
  Latency latency;
};

void Pin(int core) {
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(static_cast<std::size_t>(core) % std::max(1U, std::thread::hardware_concurrency()), &set);
  sched_setaffinity(0, sizeof set, &set);
}

double CpuSeconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

double ResidentKb() {
  std::ifstream in("/proc/self/statm");
  double pages = 0.0;
  double resident = 0.0;
  in >> pages >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1024.0;
}

/// Seconds on a clock that all processes of the machine share.
double Now() {
  return std::chrono::duration<double>(SteadyClock::now().time_since_epoch()).count();
}

/// One viewer of the client process: splits its stream into frames and reads their time stamps.
struct Reader {
  std::string bytes;

  template <typename OnFrame>
  void Take(const char* data, std::size_t size, OnFrame on_frame) {
    bytes.append(data, size);
    std::size_t at = 0;
    while (bytes.size() - at >= 2) {
      const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(bytes[at + i]); };
      std::size_t length = byte(1) & 0x7F;
      std::size_t header = 2;
      if (length == 126) {
        if (bytes.size() - at < 4) break;
        length = (static_cast<std::size_t>(byte(2)) << 8) | byte(3);
        header = 4;
      }
      if (bytes.size() - at < header + length) break;
      if ((byte(0) & 0x0F) == 2) on_frame(bytes.data() + at + header);
      at += header + length;
    }
    bytes.erase(0, at);
  }
};

/// The client process: connects, reads until every socket has closed, reports.
[[noreturn]] void Clients(const Load& load, std::uint16_t port, int report_fd) {
  Pin(1);
  const int epoll = epoll_create1(0);
  std::vector<int> sockets;
  std::vector<Reader> readers(static_cast<std::size_t>(load.viewers));
  for (int i = 0; i < load.viewers; ++i) {
    const int fd = socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) _exit(1);
    epoll_event event{};
    event.events = EPOLLIN;
    event.data.u32 = static_cast<std::uint32_t>(i);
    epoll_ctl(epoll, EPOLL_CTL_ADD, fd, &event);
    sockets.push_back(fd);
  }
  std::vector<float> latencies;
  latencies.reserve(static_cast<std::size_t>(load.viewers) *
                    static_cast<std::size_t>(load.frames()));
  std::array<epoll_event, 512> events;
  std::array<char, 65536> buffer;
  int open = load.viewers;
  while (open > 0) {
    const int count = epoll_wait(epoll, events.data(), static_cast<int>(events.size()), 10'000);
    if (count <= 0) break;
    for (int e = 0; e < count; ++e) {
      const auto i = events[static_cast<std::size_t>(e)].data.u32;
      const ssize_t got = recv(sockets[i], buffer.data(), buffer.size(), MSG_DONTWAIT);
      if (got <= 0) {
        epoll_ctl(epoll, EPOLL_CTL_DEL, sockets[i], nullptr);
        --open;
        continue;
      }
      const double now = Now();
      readers[i].Take(buffer.data(), static_cast<std::size_t>(got), [&](const char* frame) {
        double sent = 0.0;  // the first value of the row block: the time of publication
        float parts[2];
        std::memcpy(parts, frame + kFrameHeaderBytes, sizeof parts);
        sent = static_cast<double>(parts[0]) + static_cast<double>(parts[1]);
        latencies.push_back(static_cast<float>((now - sent) * 1e3));
      });
    }
  }
  Latency out;
  out.frames = latencies.size();
  if (!latencies.empty()) {
    std::sort(latencies.begin(), latencies.end());
    out.p50_ms = static_cast<double>(latencies[latencies.size() / 2]);
    out.p99_ms = static_cast<double>(latencies[latencies.size() * 99 / 100]);
    out.max_ms = static_cast<double>(latencies.back());
  }
  const bool told = write(report_fd, &out, sizeof out) == sizeof out;
  _exit(told ? 0 : 1);
}

/// A row whose first two channels carry the time of publication, as whole and fractional seconds.
std::vector<StreamRow> StampedRows(const Load& load) {
  std::vector<StreamRow> rows(static_cast<std::size_t>(load.rows()));
  const double now = Now();
  const double whole = std::floor(now / 64.0) * 64.0;
  rows[0].values[0] = static_cast<float>(whole);
  rows[0].values[1] = static_cast<float>(now - whole);
  return rows;
}

/// Accepts the clients, hands their sockets to `take`, runs `play`, closes by `finish`.
template <typename Take, typename Play, typename Finish>
Cost Measure(const Load& load, Take take, Play play, Finish finish) {
  const int listener = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  if (bind(listener, reinterpret_cast<sockaddr*>(&address), size) != 0 ||
      listen(listener, 4096) != 0) {
    std::perror("listen");
    std::exit(1);
  }
  getsockname(listener, reinterpret_cast<sockaddr*>(&address), &size);
  int report[2];
  if (pipe(report) != 0) std::exit(1);
  std::fflush(stdout);
  const pid_t child = fork();
  if (child == 0) Clients(load, ntohs(address.sin_port), report[1]);
  const double resident = ResidentKb();
  for (int i = 0; i < load.viewers; ++i) {
    take(accept4(listener, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
  }
  const double cpu = CpuSeconds();
  const double start = Now();
  auto next = SteadyClock::now();
  const auto step = std::chrono::nanoseconds(1'000'000'000 / load.frames_per_s);
  for (int frame = 0; frame < load.frames(); ++frame) {
    next += step;
    std::this_thread::sleep_until(next);
    play(frame);
  }
  Cost cost;
  const double used = CpuSeconds() - cpu;
  cost.core_percent = 100.0 * used / (Now() - start);
  cost.us_per_frame = 1e6 * used / (static_cast<double>(load.frames()) * load.viewers);
  cost.kb_per_viewer = (ResidentKb() - resident) / load.viewers;
  finish();
  if (read(report[0], &cost.latency, sizeof cost.latency) != sizeof cost.latency) std::exit(1);
  waitpid(child, nullptr, 0);
  close(report[0]);
  close(report[1]);
  close(listener);
  return cost;
}

/// Encodes once and calls send() for each viewer; nothing else.
Cost BareLoop(const Load& load) {
  std::vector<int> sockets;
  return Measure(
      load,
      [&](int fd) {
        const int on = 1;
        setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
        sockets.push_back(fd);
      },
      [&](int frame) {
        const std::string bytes =
            websocket::EncodeFrame(websocket::Opcode::kBinary,
                                   EncodeFrameMessage(StampedRows(load), frame * load.rows(), 0.0));
        for (const int fd : sockets) {
          if (send(fd, bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL) < 0) {
            std::perror("send");
          }
        }
      },
      [&] {
        for (const int fd : sockets) close(fd);
      });
}

Cost Hub(const Load& load) {
  SystemClock clock;
  StreamHubOptions options;
  options.viewers_max = static_cast<std::size_t>(load.viewers);
  options.viewers_per_caller_max = options.viewers_max;
  StreamHub hub(options, clock);
  if (!hub.Start().ok()) std::exit(1);
  hub.OpenChannel({"bench", clock.Monotonic(), {}}, "\"run\":\"bench\"");
  const Cost cost = Measure(
      load,
      [&](int fd) {
        hub.Adopt({fd, {}}, "bench", {.caller = "bench", .account_id = 1}, false);
      },
      [&](int frame) { hub.Publish("bench", frame * load.rows(), StampedRows(load)); },
      [&] { hub.Stop(); });
  if (hub.counters().messages_dropped > 0) {
    std::printf("dropped %llu messages\n",
                static_cast<unsigned long long>(hub.counters().messages_dropped));
  }
  return cost;
}

void Print(const char* what, const Load& load, const Cost& cost) {
  std::printf(
      "%-10s %5d viewers x %3d frames/s: %5.1f %% of a core, %5.2f us/frame, latency p50 %6.2f "
      "p99 %6.2f max %6.2f ms, %5.2f kB/viewer, %llu of %llu frames\n",
      what,
      load.viewers,
      load.frames_per_s,
      cost.core_percent,
      cost.us_per_frame,
      cost.latency.p50_ms,
      cost.latency.p99_ms,
      cost.latency.max_ms,
      cost.kb_per_viewer,
      static_cast<unsigned long long>(cost.latency.frames),
      static_cast<unsigned long long>(load.viewers) *
          static_cast<unsigned long long>(load.frames()));
}

}  // namespace
}  // namespace faultlab::server

int main(int argc, char** argv) {
  using namespace faultlab::server;
  Load load;
  if (argc > 1) load.viewers = std::atoi(argv[1]);
  if (argc > 2) load.frames_per_s = std::atoi(argv[2]);
  if (argc > 3) load.seconds = std::atoi(argv[3]);
  rlimit limit{};
  getrlimit(RLIMIT_NOFILE, &limit);
  limit.rlim_cur = limit.rlim_max;
  setrlimit(RLIMIT_NOFILE, &limit);
  Pin(0);
  const Cost bare = BareLoop(load);
  Print("bare loop", load, bare);
  const Cost hub = Hub(load);
  Print("hub", load, hub);
  std::printf("ratio hub / bare loop: %.2f (goal <= 1.25)\n", hub.us_per_frame / bare.us_per_frame);
  return 0;
}

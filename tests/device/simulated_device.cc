#include "tests/device/simulated_device.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <pthread.h>
#include <sched.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <span>
#include <utility>
#include <vector>

#include "core/types/check.h"
#include "tests/support/paths.h"

namespace faultlab::hardware {
namespace {

constexpr std::uint64_t kSliceCycles = 8000;  ///< 500 us
/// A device does not wait until the host's programs let it run.
constexpr int kPriority = 60;
/// After it was held up, real time goes on from here.
constexpr std::chrono::milliseconds kCatchUpMax(20);

class DeviceClock final : public Clock {
 public:
  explicit DeviceClock(SimulatedDevice& device) : device_(device) {}
  Nanoseconds Now() const override { return device_.now(); }
  Wake SleepUntil(Nanoseconds deadline) override {
    device_.RunUntil(deadline);
    return {};
  }

 private:
  SimulatedDevice& device_;
};

std::span<const std::uint8_t> BytesOf(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

std::string TextOf(const std::vector<std::uint8_t>& bytes) {
  return {bytes.begin(), bytes.end()};
}

}  // namespace

SimulatedDevice::SimulatedDevice(Line line)
    : line_(line),
      bench_(std::make_unique<BenchAtPins>(tests::InBuild("tests/device/device_firmware.elf"))) {
  if (line_ == Line::kTerminal) {
    peer_ = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    LAB_CHECK(peer_ >= 0 && grantpt(peer_) == 0 && unlockpt(peer_) == 0);
    std::array<char, 128> name{};
    LAB_CHECK(ptsname_r(peer_, name.data(), name.size()) == 0);
    port_ = name.data();
    terminal_ = open(name.data(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    LAB_CHECK(terminal_ >= 0);
  } else {
    listener_ = socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    LAB_CHECK(bind(listener_, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0);
    LAB_CHECK(listen(listener_, 4) == 0);
    socklen_t size = sizeof address;
    getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size);
    port_ = std::string(line_ == Line::kTcp ? "tcp" : "serial-server") +
            ":127.0.0.1:" + std::to_string(ntohs(address.sin_port));
    from_host_framing_ = MakeLengthFraming();
    to_host_framing_ = MakeCobsFraming();
  }
  RunUntil(std::chrono::milliseconds(5));  // it boots
}

SimulatedDevice::~SimulatedDevice() {
  ending_ = true;
  if (real_time_.joinable()) real_time_.join();
  for (const int each : {listener_, peer_, terminal_}) {
    if (each >= 0) close(each);
  }
}

std::shared_ptr<Clock> SimulatedDevice::clock() {
  return std::make_shared<DeviceClock>(*this);
}

Nanoseconds SimulatedDevice::now() {
  const std::lock_guard lock(mutex_);
  return Nanoseconds(static_cast<std::int64_t>(avr_chip_cycle(bench_->chip()) * 125 / 2));
}

void SimulatedDevice::RunUntil(Nanoseconds time) {
  const std::lock_guard lock(mutex_);
  Run(static_cast<std::uint64_t>(time.count() * 2 / 125));
}

void SimulatedDevice::Run(std::uint64_t cycle) {
  avr_chip* chip = bench_->chip();
  MoveBytes();
  while (alive_ && avr_chip_cycle(chip) < cycle) {
    alive_ = avr_chip_run(chip, std::min(cycle, avr_chip_cycle(chip) + kSliceCycles)) != 0;
    MoveBytes();
  }
}

void SimulatedDevice::RunInRealTime() {
  real_time_ = std::thread([this] {
    const sched_param parameters{.sched_priority = kPriority};
    (void)pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters);
    auto before = std::chrono::steady_clock::now();
    while (!ending_) {
      std::this_thread::sleep_for(std::chrono::microseconds(500));
      const auto wall = std::chrono::steady_clock::now();
      const Nanoseconds passed = std::min<Nanoseconds>(wall - before, kCatchUpMax);
      before = wall;
      RunUntil(now() + passed);
    }
  });
}

void SimulatedDevice::TakeConnection() {
  if (listener_ < 0) return;
  const int made = accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
  if (made < 0) return;
  const int on = 1;
  setsockopt(made, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  if (peer_ >= 0) close(peer_);
  peer_ = made;
  to_host_.clear();
  from_host_framing_->Restart();
  to_host_framing_->Restart();
}

void SimulatedDevice::FromHost(std::string_view bytes) {
  const auto deliver = [this](std::span<const std::uint8_t> wire) {
    bench_->to_device.insert(bench_->to_device.end(), wire.begin(), wire.end());
  };
  if (line_ != Line::kTcp) {
    deliver(BytesOf(bytes));
    return;
  }
  std::vector<Frame> frames;
  from_host_framing_->Take(BytesOf(bytes), frames);
  for (const Frame& frame : frames) deliver(MakeCobsFraming()->Wrap(frame));
}

void SimulatedDevice::ToHost(std::string_view bytes) {
  if (line_ != Line::kTcp) {
    to_host_ += bytes;
    return;
  }
  std::vector<Frame> frames;
  to_host_framing_->Take(BytesOf(bytes), frames);
  for (const Frame& frame : frames) to_host_ += TextOf(MakeLengthFraming()->Wrap(frame));
}

void SimulatedDevice::Hit(std::string& bytes) {
  for (char& byte : bytes) {
    noise_state_ = noise_state_ * 1664525u + 1013904223u;
    if ((noise_state_ >> 8) * 0x1p-24 >= noise_) continue;
    byte = static_cast<char>(byte ^ 0x10);
    ++noise_hits_;
  }
}

void SimulatedDevice::MoveBytes() {
  TakeConnection();
  std::string sent = std::exchange(bench_->from_device, {});
  Hit(sent);
  if (!cut_) ToHost(sent);
  if (peer_ < 0) return;
  std::array<char, 4096> bytes{};
  ssize_t size = 0;
  while ((size = read(peer_, bytes.data(), bytes.size())) > 0) {
    std::string taken(bytes.data(), static_cast<std::size_t>(size));
    Hit(taken);
    if (!cut_) FromHost(taken);
  }
  if (size == 0 && line_ != Line::kTerminal) {
    close(peer_);
    peer_ = -1;
    to_host_.clear();
    return;
  }
  if (to_host_.empty()) return;
  size = line_ == Line::kTerminal ? write(peer_, to_host_.data(), to_host_.size())
                                  : send(peer_, to_host_.data(), to_host_.size(), MSG_NOSIGNAL);
  if (size > 0) to_host_.erase(0, static_cast<std::size_t>(size));
}

Nanoseconds SimulatedDevice::CutCable(bool cut) {
  const std::lock_guard lock(mutex_);
  cut_ = cut;
  return Nanoseconds(static_cast<std::int64_t>(avr_chip_cycle(bench_->chip()) * 125 / 2));
}

void SimulatedDevice::HangUp() {
  const std::lock_guard lock(mutex_);
  for (int* each : {&peer_, &terminal_, &listener_}) {
    if (*each >= 0) close(std::exchange(*each, -1));
  }
}

Nanoseconds SimulatedDevice::PressReset() {
  const std::lock_guard lock(mutex_);
  avr_chip_reset(bench_->chip());
  return Nanoseconds(static_cast<std::int64_t>(avr_chip_cycle(bench_->chip()) * 125 / 2));
}

void SimulatedDevice::InjectToDevice(std::string bytes) {
  const std::lock_guard lock(mutex_);
  bench_->to_device.insert(bench_->to_device.end(), bytes.begin(), bytes.end());
}

void SimulatedDevice::InjectToHost(std::string bytes) {
  const std::lock_guard lock(mutex_);
  to_host_ += bytes;
}

void SimulatedDevice::SetNoise(double probability) {
  const std::lock_guard lock(mutex_);
  noise_ = probability;
}

void SimulatedDevice::SwapEncoder() {
  const std::lock_guard lock(mutex_);
  bench_->SwapEncoder();
}

void SimulatedDevice::FloodEncoder(bool on) {
  const std::lock_guard lock(mutex_);
  bench_->FloodEncoder(on);
}

void SimulatedDevice::StickLines(std::uint32_t connected) {
  const std::lock_guard lock(mutex_);
  bench_->StickLines(connected);
}

int SimulatedDevice::noise_hits() {
  const std::lock_guard lock(mutex_);
  return noise_hits_;
}

bool SimulatedDevice::IsSafe() {
  const std::lock_guard lock(mutex_);
  return bench_->drive_v() == 0.0 && bench_->lines() == BenchAtPins::kNominal;
}

Nanoseconds SimulatedDevice::drive_zero_at() {
  const std::lock_guard lock(mutex_);
  return Nanoseconds(static_cast<std::int64_t>(bench_->drive_zero_at() * 125 / 2));
}

double SimulatedDevice::drive_v() {
  const std::lock_guard lock(mutex_);
  return bench_->drive_v();
}

std::uint32_t SimulatedDevice::lines() {
  const std::lock_guard lock(mutex_);
  return bench_->lines();
}

RelayAbuse SimulatedDevice::abuse() {
  const std::lock_guard lock(mutex_);
  return bench_->abuse();
}

double SimulatedDevice::load() {
  const std::lock_guard lock(mutex_);
  const std::uint64_t busy = avr_chip_busy_cycles(bench_->chip());
  const std::uint64_t cycle = avr_chip_cycle(bench_->chip());
  const double share = static_cast<double>(busy - busy_before_) /
                       static_cast<double>(std::max<std::uint64_t>(cycle - cycle_before_, 1));
  busy_before_ = busy;
  cycle_before_ = cycle;
  return share;
}

std::uint64_t SimulatedDevice::uart_overruns() {
  const std::lock_guard lock(mutex_);
  return avr_chip_overruns(bench_->chip());
}

bool SimulatedDevice::alive() {
  const std::lock_guard lock(mutex_);
  return alive_;
}

}  // namespace faultlab::hardware

#include "hardware/comedi/analog_scan.h"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <exception>
#include <utility>

namespace faultlab::hardware {
namespace {

using std::chrono::nanoseconds;

/// Between two conversions of a scan: a multiplexer settles in it.
constexpr nanoseconds kConvert = std::chrono::microseconds(20);
/// A scan may take this part of delta: its values are of one instant for whoever uses them.
constexpr int kScansInDelta = 20;
/// The board's timer may miss delta by this part.
constexpr int kDeltaParts = 100;
/// Period of the trial: long beside the delays of an interrupt, short beside a caller's patience.
constexpr nanoseconds kTrial = std::chrono::milliseconds(10);
constexpr int kTrials = 2;

}  // namespace

std::unique_ptr<AnalogScan> AnalogScan::Of(const ComediBoard& board,
                                           Inputs inputs,
                                           double delta_s) {
  std::unique_ptr<AnalogScan> scan(new AnalogScan(board, std::move(inputs)));
  try {
    if (scan->Plan(delta_s) && scan->TellFirstScan()) return scan;
  } catch (const IoError&) {
    // Single reads need none of this.
  }
  return nullptr;
}

AnalogScan::AnalogScan(const ComediBoard& board, Inputs inputs)
    : board_(board), inputs_(std::move(inputs)) {}

AnalogScan::~AnalogScan() {
  Cancel();
}

bool AnalogScan::Plan(double delta_s) {
  const ComediApi& api = board_.api();
  const int flags = api.get_flags(board_.device(), inputs_.subdevice);
  if (flags < 0 || (flags & SDF_CMD_READ) == 0) return false;
  if (api.set_read_subdevice(board_.device(), inputs_.subdevice) < 0) return false;
  const int file = api.file_number(board_.device());
  if (file < 0 || fcntl(file, F_SETFL, fcntl(file, F_GETFL) | O_NONBLOCK) < 0) return false;
  value_bytes_ = (flags & SDF_LSAMPL) != 0 ? sizeof(lsampl_t) : sizeof(sampl_t);
  const nanoseconds delta(std::llround(delta_s * 1e9));
  command_ = Command(delta, 1);
  if (!Test(command_)) return false;
  const auto half_scan = [&] {
    return nanoseconds(command_.convert_arg) * (inputs_.channels.size() - 1) / 2;
  };
  if (2 * half_scan() * kScansInDelta > delta) return false;
  command_.scan_begin_arg = static_cast<unsigned>((delta - half_scan()).count());
  if (!Test(command_)) return false;
  middle_ = nanoseconds(command_.scan_begin_arg) + half_scan();
  return std::chrono::abs(middle_ - delta) <= delta / kDeltaParts;
}

/// Sets the number of scans. A late wake-up makes a scan look later than it was, so one early scan
/// is proof, and a late one is tried again.
bool AnalogScan::TellFirstScan() {
  for (int trial = 0; trial < kTrials; ++trial) {
    comedi_cmd command = Command(kTrial, 1);
    command.convert_arg = command_.convert_arg;
    if (!Test(command)) return false;
    Begin(command);
    const auto began = Steady::now();
    (void)Fetch(inputs_.channels.size(), began + nanoseconds(command.scan_begin_arg) + kPatience);
    const bool at_once = Steady::now() - began < nanoseconds(command.scan_begin_arg) / 2;
    Cancel();
    command_.stop_arg = at_once ? 2 : 1;
    if (at_once) break;
  }
  return Test(command_);
}

comedi_cmd AnalogScan::Command(nanoseconds scan_begin, unsigned scans) {
  comedi_cmd command{};
  command.subdev = inputs_.subdevice;
  command.flags = CMDF_WAKE_EOS;
  command.start_src = TRIG_NOW;
  command.scan_begin_src = TRIG_TIMER;
  command.scan_begin_arg = static_cast<unsigned>(scan_begin.count());
  command.convert_src = TRIG_TIMER;
  command.convert_arg = static_cast<unsigned>(kConvert.count());
  command.scan_end_src = TRIG_COUNT;
  command.scan_end_arg = static_cast<unsigned>(inputs_.channels.size());
  command.stop_src = TRIG_COUNT;
  command.stop_arg = scans;
  command.chanlist = inputs_.channels.data();
  command.chanlist_len = static_cast<unsigned>(inputs_.channels.size());
  return command;
}

bool AnalogScan::Test(comedi_cmd& command) const {
  constexpr int kSteps = 5;  // of Comedi's test: each corrects what it complains about
  for (int step = 0; step < kSteps; ++step) {
    const int wrong = board_.api().command_test(board_.device(), &command);
    if (wrong <= 0) return wrong == 0;
  }
  return false;
}

void AnalogScan::Begin(comedi_cmd& command) {
  if (board_.api().command(board_.device(), &command) < 0) board_.Fail("comedi_command");
  pending_ = true;
}

void AnalogScan::Start() noexcept {
  edge_ = Steady::now();
  try {
    Cancel();
    failure_.clear();
    Begin(command_);
  } catch (const std::exception& error) {
    failure_ = error.what();
  }
  began_ = Steady::now();
}

AnalogScan::Scan AnalogScan::Collect() {
  if (!pending_) {
    throw IoError(failure_.empty() ? "no scan was begun: the drive comes first" : failure_);
  }
  const std::size_t values = inputs_.channels.size();
  std::vector<lsampl_t> codes =
      Fetch(values * command_.stop_arg, began_ + 2 * middle_ + nanoseconds(kPatience));
  Cancel();
  codes.erase(codes.begin(), codes.end() - static_cast<std::ptrdiff_t>(values));
  const std::chrono::duration<double> middle = began_ - edge_ + middle_;
  return {.codes = std::move(codes), .middle_after_s = middle.count()};
}

std::vector<lsampl_t> AnalogScan::Fetch(std::size_t values, Steady::time_point deadline) {
  const int file = board_.api().file_number(board_.device());
  if (file < 0) board_.Fail("comedi_fileno");
  std::vector<std::byte> bytes(values * value_bytes_);
  std::size_t here = 0;
  bool ended = false;
  while (here < bytes.size()) {
    const ssize_t got = read(file, &bytes[here], bytes.size() - here);
    if (got > 0) {
      here += static_cast<std::size_t>(got);
      continue;
    }
    if (got == 0) {
      // Linux looks for values first and then whether the scan goes on, so that of a scan that ends
      // in between it says the end before its values: they are there at the next look.
      if (ended) throw IoError("the board ended its scan too early");
      ended = true;
      continue;
    }
    if (errno == EINTR) continue;
    if (errno != EAGAIN) {
      throw IoError(std::string("reading the scan failed: ") + std::strerror(errno));
    }
    // Read once more after the deadline: who was late to wake up is not without its values, and
    // only a read tells of a device that has gone.
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Steady::now());
    if (left.count() <= 0) {
      throw IoError(
          "the scan of the analog inputs does not come: " + std::to_string(here / value_bytes_) +
          " of " + std::to_string(values) + " values are there");
    }
    pollfd ready{.fd = file, .events = POLLIN, .revents = 0};
    (void)poll(&ready, 1, static_cast<int>(left.count()));
  }
  std::vector<lsampl_t> codes(values, 0);
  for (std::size_t i = 0; i < values; ++i) {
    // Little-endian or not: a value is as wide as it is in memory.
    if (value_bytes_ == sizeof(sampl_t)) {
      sampl_t code = 0;
      std::memcpy(&code, &bytes[i * sizeof code], sizeof code);
      codes[i] = code;
    } else {
      std::memcpy(&codes[i], &bytes[i * sizeof(lsampl_t)], sizeof(lsampl_t));
    }
  }
  return codes;
}

void AnalogScan::Cancel() noexcept {
  // A command that has ended is not in the way; one that does not end makes the next one fail.
  if (std::exchange(pending_, false)) {
    (void)board_.api().cancel(board_.device(), inputs_.subdevice);
  }
}

}  // namespace faultlab::hardware

// A stand-in for libcomedi: declared by the real header, answers from the plant.
#include <comedilib.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <thread>
#include <vector>

#include "core/plant/converters.h"
#include "tests/hardware/stand_in_plant.h"

namespace {

using namespace faultlab;
using namespace faultlab::hardware;

StandInPlant plant;
int device_mark = 0;
comedi_range ten_volts = {-10.0, 10.0, UNIT_volt};
constexpr lsampl_t kMaxData = 65535;
/// An 8255's number of lines; directions one by one, as on other boards.
constexpr unsigned kDigitalLines = 24;
unsigned latch = 0;  ///< before a program writes it: all relays on
unsigned outputs = 0;
bool drive_written = false;  ///< since the device was opened
bool counter_armed = false;
constexpr lsampl_t kCounterMax = 0xffff;  ///< wraps every other second

constexpr unsigned kAnalogIn = 0;
constexpr unsigned kAnalogOut = 1;
constexpr unsigned kDigital = 2;
constexpr unsigned kCounter = 3;
/// Lines of the paper's bench that connect the nominal parts.
constexpr unsigned kNominalLow = 1u << 17 | 1u << 19 | 1u << 21 | 1u << 6;

/// The command that goes on; its values come in one packet, after empty ones that say the end.
struct Scans {
  comedi_cmd command{};
  bool going_on = false;
  bool ended = false;  ///< all its values are there
  int ends[2] = {-1, -1};
};
Scans scans;
constexpr unsigned kConvertMinNs = 5000;
constexpr unsigned kTimerNs = 1000;  ///< all times are multiples of it

bool IsOpen(comedi_t* device) {
  const bool ok = reinterpret_cast<int*>(device) == &device_mark && plant.control.open_handles == 1;
  if (!ok) plant.Misuse("a device that is not open");
  return ok;
}

/// 0..65535 for -10..10 V, as on a 16-bit board.
lsampl_t Code(double volt) {
  return static_cast<lsampl_t>(core::ConverterCode(volt, 10.0) + 32768);
}

AnalogReading ReadTogether() {
  return plant.daq().ReadAnalog();
}

unsigned Rounded(unsigned time_ns) {
  return (time_ns + kTimerNs / 2) / kTimerNs * kTimerNs;
}

/// The scans of the command. Those before the last one are of a board that the test does not look
/// at: they are not of the plant.
void MakeValues() {
  const comedi_cmd& command = scans.command;
  std::vector<sampl_t> values;
  for (unsigned scan = 1; scan < command.stop_arg; ++scan) {
    values.insert(values.end(), command.chanlist_len, sampl_t{0xdead});
  }
  // A single scan at once is of no drive's edge: a trial.
  const bool trial = plant.control.scans == StandInScans::kAtOnce && command.stop_arg == 1;
  const AnalogReading last = trial ? AnalogReading{} : ReadTogether();
  for (unsigned i = 0; i < command.chanlist_len; ++i) {
    const unsigned channel = CR_CHAN(command.chanlist[i]);
    const double volt = channel == 0 ? last.um_v : channel == 1 ? last.ua_v : last.ia_v;
    values.push_back(static_cast<sampl_t>(Code(volt)));
  }
  for (int i = 0; i < plant.control.scans_say_end; ++i) {
    if (send(scans.ends[1], values.data(), 0, 0) != 0) plant.Misuse("no end can be said");
  }
  const std::size_t bytes = values.size() * sizeof(sampl_t);
  if (write(scans.ends[1], values.data(), bytes) != static_cast<ssize_t>(bytes)) {
    plant.Misuse("more values than the buffer holds");
  }
}

void Drain() {
  char rest[4096];
  while (read(scans.ends[0], rest, sizeof rest) >= 0) {
  }
}

}  // namespace

extern "C" {

StandInControl* stand_in_control() {
  return &plant.control;
}

comedi_t* comedi_open(const char* file) {
  if (plant.Called() || std::strncmp(file, "/dev/comedi", 11) != 0) return nullptr;
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK, 0, scans.ends) != 0) return nullptr;
  ++plant.control.open_handles;
  drive_written = false;
  return reinterpret_cast<comedi_t*>(&device_mark);
}

int comedi_close(comedi_t* device) {
  if (!IsOpen(device)) return 0;
  --plant.control.open_handles;
  scans.going_on = false;
  for (const int end : scans.ends) close(end);
  return 0;
}

int comedi_errno() {
  return 5;
}
const char* comedi_strerror(int) {
  return "the stand-in was told to fail";
}

int comedi_get_n_subdevices(comedi_t* device) {
  return plant.Called() || !IsOpen(device) ? -1 : 4;
}
int comedi_get_subdevice_type(comedi_t* device, unsigned subdevice) {
  if (plant.Called() || !IsOpen(device)) return -1;
  switch (subdevice) {
    case kAnalogIn:
      return COMEDI_SUBD_AI;
    case kAnalogOut:
      return COMEDI_SUBD_AO;
    case kDigital:
      return COMEDI_SUBD_DIO;
    default:
      return COMEDI_SUBD_COUNTER;
  }
}
int comedi_get_subdevice_flags(comedi_t* device, unsigned subdevice) {
  if (plant.Called() || !IsOpen(device)) return -1;
  if (subdevice != kAnalogIn) plant.Misuse("flags");
  return plant.control.scans == StandInScans::kNone ? SDF_READABLE : SDF_READABLE | SDF_CMD_READ;
}
int comedi_set_read_subdevice(comedi_t* device, unsigned subdevice) {
  if (plant.Called() || !IsOpen(device)) return -1;
  if (subdevice != kAnalogIn) plant.Misuse("subdevice for reading");
  return 0;
}

int comedi_get_n_channels(comedi_t* device, unsigned subdevice) {
  if (plant.Called() || !IsOpen(device)) return -1;
  return subdevice == kDigital ? static_cast<int>(kDigitalLines) : subdevice == kCounter ? 1 : 3;
}

lsampl_t comedi_get_maxdata(comedi_t* device, unsigned subdevice, unsigned) {
  if (subdevice == kCounter) return kCounterMax;
  return IsOpen(device) && subdevice <= kAnalogOut ? kMaxData : 0;
}
comedi_range* comedi_get_range(comedi_t* device, unsigned subdevice, unsigned, unsigned range) {
  return IsOpen(device) && subdevice <= kAnalogOut && range == 0 ? &ten_volts : nullptr;
}

double comedi_to_phys(lsampl_t data, comedi_range*, lsampl_t) {
  return (static_cast<double>(data) - 32768.0) * (2.0 * 10.0 / core::kConverterSteps);
}
lsampl_t comedi_from_phys(double volt, comedi_range*, lsampl_t) {
  return Code(volt);
}

int comedi_data_read(comedi_t* device,
                     unsigned subdevice,
                     unsigned channel,
                     unsigned,
                     unsigned aref,
                     lsampl_t* data) {
  if (plant.Called() || !IsOpen(device)) return -1;
  if (subdevice == kCounter) {
    if (!counter_armed) plant.Misuse("a counter that was not armed");
    const lsampl_t pulses = plant.daq().ReadPulseCount();
    *data = ((plant.control.swapped ? 0 - pulses : pulses) + kCounterMax - 5) & kCounterMax;
    return 1;
  }
  if (subdevice != kAnalogIn || channel > 2 || aref != AREF_DIFF) plant.Misuse("AI read");
  if (scans.going_on) plant.Misuse("AI read during a command");
  // One scan is three reads at one instant, so the noise is drawn once.
  static AnalogReading scan;
  if (channel == 0) scan = ReadTogether();
  *data = Code(channel == 0 ? scan.um_v : channel == 1 ? scan.ua_v : scan.ia_v);
  return 1;
}

int comedi_data_write(
    comedi_t* device, unsigned subdevice, unsigned channel, unsigned, unsigned, lsampl_t data) {
  if (plant.Called() || !IsOpen(device)) return -1;
  if (subdevice != kAnalogOut || channel != 0 || data > kMaxData) plant.Misuse("AO write");
  drive_written = true;
  plant.Drive(comedi_to_phys(data, nullptr, 0));
  return 1;
}

int comedi_dio_config(comedi_t* device, unsigned subdevice, unsigned channel, unsigned direction) {
  if (plant.Called() || !IsOpen(device)) return -1;
  if (channel >= kDigitalLines) return -1;  // "Invalid channel"
  if (subdevice != kDigital || direction != COMEDI_OUTPUT) {
    plant.Misuse("DIO configuration");
  }
  if (!drive_written) plant.Misuse("relay lines before the drive is 0");
  if ((latch & 1u << channel) == 0 && (kNominalLow & 1u << channel) == 0) {
    plant.Misuse("a line that becomes an output and connects its part");
  }
  outputs |= 1u << channel;
  plant.Relays(latch | ~outputs);
  return 0;
}

int comedi_dio_get_config(comedi_t* device, unsigned subdevice, unsigned channel, unsigned* is) {
  if (plant.Called() || !IsOpen(device)) return -1;
  if (subdevice != kDigital || channel >= kDigitalLines) plant.Misuse("DIO query");
  *is = (outputs & 1u << channel) != 0 ? COMEDI_OUTPUT : COMEDI_INPUT;
  return 0;
}

int comedi_dio_bitfield2(
    comedi_t* device, unsigned subdevice, unsigned mask, unsigned* bits, unsigned base) {
  if (plant.Called() || !IsOpen(device)) return -1;
  if (subdevice != kDigital || base != 0) plant.Misuse("DIO bits");
  if (mask != 0) {
    latch = (latch & ~mask) | (*bits & mask);
    plant.Relays(latch | ~outputs);
  }
  *bits = plant.daq().ReadRelayLines();
  return 0;
}

int comedi_reset(comedi_t* device, unsigned subdevice) {
  if (plant.Called() || !IsOpen(device)) return -1;
  if (subdevice != kCounter) plant.Misuse("reset");
  return 0;
}

int comedi_arm(comedi_t* device, unsigned subdevice, unsigned) {
  if (plant.Called() || !IsOpen(device)) return -1;
  if (subdevice != kCounter) plant.Misuse("arm");
  counter_armed = true;
  return 0;
}

int comedi_command_test(comedi_t* device, comedi_cmd* command) {
  if (plant.Called() || !IsOpen(device)) return -1;
  if (plant.control.scans == StandInScans::kNone) return 1;
  if (command->start_src != TRIG_NOW || command->scan_begin_src != TRIG_TIMER ||
      command->convert_src != TRIG_TIMER || command->scan_end_src != TRIG_COUNT ||
      command->stop_src != TRIG_COUNT) {
    return 1;
  }
  const comedi_cmd before = *command;
  command->convert_arg = std::max(command->convert_arg, kConvertMinNs);
  command->scan_begin_arg =
      std::max(command->scan_begin_arg, command->convert_arg * command->scan_end_arg);
  if (command->convert_arg != before.convert_arg ||
      command->scan_begin_arg != before.scan_begin_arg ||
      command->scan_end_arg != command->chanlist_len || command->stop_arg == 0) {
    return 3;
  }
  command->convert_arg = Rounded(command->convert_arg);
  command->scan_begin_arg = Rounded(command->scan_begin_arg);
  return command->convert_arg != before.convert_arg ||
                 command->scan_begin_arg != before.scan_begin_arg
             ? 4
             : 0;
}

int comedi_command(comedi_t* device, comedi_cmd* command) {
  if (plant.Called() || !IsOpen(device)) return -1;
  if (scans.going_on) plant.Misuse("a command while another goes on");
  if (Rounded(command->scan_begin_arg) != command->scan_begin_arg) plant.Misuse("untested command");
  scans.command = *command;
  scans.going_on = true;
  scans.ended = false;
  ++plant.control.commands;
  return 0;
}

/// Whoever asks for the file is about to read: the scans are made now, of the plant as it is now,
/// because the test's time stands between the command and the reading.
int comedi_fileno(comedi_t* device) {
  if (plant.Called() || !IsOpen(device)) return -1;
  if (scans.going_on && !scans.ended && !plant.control.scans_silent) {
    if (plant.control.scans == StandInScans::kAfterAPeriod) {
      std::this_thread::sleep_for(std::chrono::nanoseconds(scans.command.scan_begin_arg));
    }
    MakeValues();
    scans.ended = true;
  }
  return scans.ends[0];
}

int comedi_cancel(comedi_t* device, unsigned subdevice) {
  if (!IsOpen(device) || subdevice != kAnalogIn) plant.Misuse("cancel");
  if (scans.going_on && !scans.ended) ++plant.control.cancels;
  scans.going_on = false;
  Drain();
  return 0;
}

}  // extern "C"

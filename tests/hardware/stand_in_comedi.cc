// A stand-in for libcomedi: declared by the real header, answers from the plant.
#include <comedilib.h>

#include <cmath>
#include <cstring>

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

bool IsOpen(comedi_t* device) {
  const bool ok = reinterpret_cast<int*>(device) == &device_mark && plant.control.open_handles == 1;
  if (!ok) plant.Misuse("a device that is not open");
  return ok;
}

/// 0..65535 for -10..10 V, as on a 16-bit board.
lsampl_t Code(double volt) {
  return static_cast<lsampl_t>(core::ConverterCode(volt, 10.0) + 32768);
}

}  // namespace

extern "C" {

StandInControl* stand_in_control() {
  return &plant.control;
}

comedi_t* comedi_open(const char* file) {
  if (plant.Called() || std::strncmp(file, "/dev/comedi", 11) != 0) return nullptr;
  ++plant.control.open_handles;
  drive_written = false;
  return reinterpret_cast<comedi_t*>(&device_mark);
}

int comedi_close(comedi_t* device) {
  if (IsOpen(device)) --plant.control.open_handles;
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
    *data = (plant.daq().ReadPulseCount() + kCounterMax - 5) & kCounterMax;
    return 1;
  }
  if (subdevice != kAnalogIn || channel > 2 || aref != AREF_DIFF) plant.Misuse("AI read");
  // One scan is three reads at one instant, so the noise is drawn once.
  static AnalogReading scan;
  if (channel == 0) scan = plant.daq().ReadAnalog();
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

}  // extern "C"

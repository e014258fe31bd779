#include "hardware/comedi/comedi_daq.h"

#include <comedilib.h>

#include <array>
#include <limits>

#include "hardware/daq/shared_library.h"

namespace faultlab::hardware {
namespace {

constexpr int kRelayLines = 32;

/// The functions of libcomedi that a bench needs, by the signatures of its own header.
struct Api {
  explicit Api(const SharedLibrary& library) {
    library.Find("comedi_open", open);
    library.Find("comedi_close", close);
    library.Find("comedi_errno", error_number);
    library.Find("comedi_strerror", error_text);
    library.Find("comedi_get_maxdata", get_maxdata);
    library.Find("comedi_get_range", get_range);
    library.Find("comedi_to_phys", to_phys);
    library.Find("comedi_from_phys", from_phys);
    library.Find("comedi_data_read", data_read);
    library.Find("comedi_data_write", data_write);
    library.Find("comedi_dio_config", dio_config);
    library.Find("comedi_dio_bitfield2", dio_bitfield2);
    library.Find("comedi_reset", reset);
    library.Find("comedi_arm", arm);
  }

  decltype(comedi_open)* open;
  decltype(comedi_close)* close;
  decltype(comedi_errno)* error_number;
  decltype(comedi_strerror)* error_text;
  decltype(comedi_get_maxdata)* get_maxdata;
  decltype(comedi_get_range)* get_range;
  decltype(comedi_to_phys)* to_phys;
  decltype(comedi_from_phys)* from_phys;
  decltype(comedi_data_read)* data_read;
  decltype(comedi_data_write)* data_write;
  decltype(comedi_dio_config)* dio_config;
  decltype(comedi_dio_bitfield2)* dio_bitfield2;
  decltype(comedi_reset)* reset;
  decltype(comedi_arm)* arm;
};

unsigned Unsigned(int value) {
  return static_cast<unsigned>(value);
}

class Comedi final : public Daq {
 public:
  explicit Comedi(const ComediChannels& channels)
      : channels_(channels),
        library_(channels.library),
        api_(library_),
        reference_(channels.reference == "diff"     ? AREF_DIFF
                   : channels.reference == "common" ? AREF_COMMON
                                                    : AREF_GROUND),
        device_(api_.open(channels.device.c_str()), api_.close) {
    if (!device_) Fail("comedi_open of " + channels.device);
    in_ = ScaleOf(channels.analog_in, channels.um);
    out_ = ScaleOf(channels.analog_out, channels.drive);
    for (int line = 0; line < kRelayLines; ++line) {
      if ((channels.relay_lines & 1u << line) == 0) continue;
      const int status = api_.dio_config(device_.get(),
                                         Unsigned(channels.digital),
                                         Unsigned(channels.relay_base + line),
                                         COMEDI_OUTPUT);
      if (status < 0) Fail("comedi_dio_config of relay line " + std::to_string(line));
    }
    if (channels.counter >= 0) {
      if (api_.reset(device_.get(), Unsigned(channels.counter)) < 0) Fail("comedi_reset");
      if (api_.arm(device_.get(), Unsigned(channels.counter), 0) < 0) Fail("comedi_arm");
    }
  }

  double WriteDrive(double terminal_v) override {
    const lsampl_t code = api_.from_phys(terminal_v, out_.range, out_.maxdata);
    const int status = api_.data_write(device_.get(),
                                       Unsigned(channels_.analog_out),
                                       Unsigned(channels_.drive),
                                       Unsigned(channels_.range),
                                       reference_,
                                       code);
    if (status < 0) Fail("comedi_data_write");
    return api_.to_phys(code, out_.range, out_.maxdata);
  }

  AnalogReading ReadAnalog() override {
    return {.um_v = ReadVolts(channels_.um),
            .ua_v = ReadVolts(channels_.ua),
            .ia_v = ReadVolts(channels_.ia)};
  }

  void WriteRelayLines(std::uint32_t levels) override { (void)Bits(channels_.relay_lines, levels); }
  std::uint32_t ReadRelayLines() override { return Bits(0, 0); }

  double ReadPulseFrequencyHz() override {
    throw IoError("Comedi counts pulses: set encoder.method = \"count\"");
  }

  std::uint32_t ReadPulseCount() override {
    if (channels_.counter < 0) throw IoError("this bench has no counter");
    lsampl_t count = 0;
    const int status = api_.data_read(device_.get(),
                                      Unsigned(channels_.counter),
                                      Unsigned(channels_.counter_channel),
                                      0,
                                      0,
                                      &count);
    if (status < 0) Fail("comedi_data_read of the counter");
    return count;
  }

  void Prepare() override {}
  void FeedWatchdog() override {}
  bool has_watchdog() const override { return false; }

 private:
  struct Scale {
    comedi_range* range = nullptr;
    lsampl_t maxdata = 0;
  };

  [[noreturn]] void Fail(const std::string& call) const {
    throw IoError(call + " failed: " + api_.error_text(api_.error_number()));
  }

  Scale ScaleOf(int subdevice, int channel) const {
    const Scale scale{
        .range = api_.get_range(
            device_.get(), Unsigned(subdevice), Unsigned(channel), Unsigned(channels_.range)),
        .maxdata = api_.get_maxdata(device_.get(), Unsigned(subdevice), Unsigned(channel))};
    if (scale.range == nullptr || scale.maxdata == 0) {
      Fail("comedi_get_range of subdevice " + std::to_string(subdevice));
    }
    return scale;
  }

  double ReadVolts(int channel) {
    if (channel < 0) return std::numeric_limits<double>::quiet_NaN();
    lsampl_t code = 0;
    const int status = api_.data_read(device_.get(),
                                      Unsigned(channels_.analog_in),
                                      Unsigned(channel),
                                      Unsigned(channels_.range),
                                      reference_,
                                      &code);
    if (status < 0) Fail("comedi_data_read of channel " + std::to_string(channel));
    return api_.to_phys(code, in_.range, in_.maxdata);
  }

  std::uint32_t Bits(unsigned mask, std::uint32_t levels) {
    unsigned bits = levels;
    const int status = api_.dio_bitfield2(
        device_.get(), Unsigned(channels_.digital), mask, &bits, Unsigned(channels_.relay_base));
    if (status < 0) Fail("comedi_dio_bitfield2");
    return bits;
  }

  const ComediChannels channels_;
  const SharedLibrary library_;
  const Api api_;
  const unsigned reference_;
  std::unique_ptr<comedi_t, decltype(comedi_close)*> device_;
  Scale in_;
  Scale out_;
};

}  // namespace

std::unique_ptr<Daq> OpenComedi(const ComediChannels& channels) {
  return std::make_unique<Comedi>(channels);
}

}  // namespace faultlab::hardware

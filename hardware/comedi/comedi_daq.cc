#include "hardware/comedi/comedi_daq.h"

#include <chrono>
#include <limits>
#include <optional>
#include <string>

#include "hardware/comedi/analog_scan.h"
#include "hardware/comedi/comedi_board.h"
#include "hardware/comedi/pulse_counter.h"
#include "hardware/comedi/relay_ports.h"

namespace faultlab::hardware {
namespace {

class Comedi final : public Daq {
 public:
  explicit Comedi(const ComediChannels& channels)
      : channels_(channels),
        board_(channels.library, channels.device),
        reference_(channels.reference == "diff"     ? AREF_DIFF
                   : channels.reference == "common" ? AREF_COMMON
                                                    : AREF_GROUND) {
    const int outputs = board_.Require("analog_out", channels.analog_out, COMEDI_SUBD_AO);
    board_.RequireChannel("drive", channels.drive, channels.analog_out, outputs);
    out_ = ScaleOf(channels.analog_out, channels.drive);
    WriteDrive(channels.drive_zero_v);  // the motor first: whatever follows may fail
    const int inputs = board_.Require("analog_in", channels.analog_in, COMEDI_SUBD_AI);
    board_.RequireChannel("um", channels.um, channels.analog_in, inputs);
    board_.RequireChannel("ua", channels.ua, channels.analog_in, inputs);
    board_.RequireChannel("ia", channels.ia, channels.analog_in, inputs);
    in_ = ScaleOf(channels.analog_in, channels.um);
    if (in_.range->max <= channels.reach_v) {
      throw IoError("the analog inputs of " + channels.device + " end at " +
                    std::to_string(in_.range->max) + " V in this range, the interlocks need " +
                    std::to_string(channels.reach_v) + " V: choose a wider comedi.range");
    }
    relays_.emplace(board_, channels);
    if (channels.counter >= 0) counter_.emplace(board_, channels);
  }

  double WriteDrive(double terminal_v) override {
    const lsampl_t code = board_.api().from_phys(terminal_v, out_.range, out_.maxdata);
    const Time before = std::chrono::steady_clock::now();
    const int status = board_.api().data_write(board_.device(),
                                               Unsigned(channels_.analog_out),
                                               Unsigned(channels_.drive),
                                               Unsigned(channels_.range),
                                               reference_,
                                               code);
    if (status < 0) board_.Fail("comedi_data_write");
    if (scan_) scan_->Start();
    drive_at_ = Middle(before);
    return board_.api().to_phys(code, out_.range, out_.maxdata);
  }

  AnalogReading ReadAnalog() override {
    if (scan_) return OfScan();
    // One after the other, which may take as long as delta: um, by which is diagnosed, comes first.
    const Time before = std::chrono::steady_clock::now();
    AnalogReading reading;
    const bool by_um = channels_.um >= 0;
    const double first_v = ReadVolts(by_um ? channels_.um : channels_.ia);
    reading.middle_after_s = std::chrono::duration<double>(Middle(before) - drive_at_).count();
    reading.um_v = by_um ? first_v : std::numeric_limits<double>::quiet_NaN();
    reading.ua_v = ReadVolts(channels_.ua);
    reading.ia_v = by_um ? ReadVolts(channels_.ia) : first_v;
    return reading;
  }

  void WriteRelayLines(std::uint32_t levels) override { relays_->Write(levels); }
  std::uint32_t ReadRelayLines() override { return relays_->Read(); }

  double ReadPulseFrequencyHz() override {
    throw IoError("Comedi counts pulses: set encoder.method = \"count\"");
  }
  std::uint32_t ReadPulseCount() override {
    if (!counter_) throw IoError("this bench has no counter");
    return counter_->Read();
  }

  void Prepare() override {
    if (!scan_ && channels_.may_scan) {
      scan_ = AnalogScan::Of(board_, Inputs(), channels_.delta_s);
    }
  }
  void FeedWatchdog() override {}
  bool has_watchdog() const override { return false; }

 private:
  using Time = std::chrono::steady_clock::time_point;
  /// A call acts about half way between its beginning and now.
  static Time Middle(Time begin) { return begin + (std::chrono::steady_clock::now() - begin) / 2; }

  struct Scale {
    comedi_range* range = nullptr;
    lsampl_t maxdata = 0;
  };

  Scale ScaleOf(int subdevice, int channel) const {
    const Scale scale{
        .range = board_.api().get_range(
            board_.device(), Unsigned(subdevice), Unsigned(channel), Unsigned(channels_.range)),
        .maxdata =
            board_.api().get_maxdata(board_.device(), Unsigned(subdevice), Unsigned(channel))};
    if (scale.range == nullptr || scale.maxdata == 0) {
      board_.Fail("comedi_get_range of subdevice " + std::to_string(subdevice) + ", range " +
                  std::to_string(channels_.range) + ",");
    }
    return scale;
  }

  /// Of the wired channels um, ua, ia, in this order.
  AnalogScan::Inputs Inputs() const {
    AnalogScan::Inputs inputs{.subdevice = Unsigned(channels_.analog_in), .channels = {}};
    for (const int channel : {channels_.um, channels_.ua, channels_.ia}) {
      if (channel < 0) continue;
      inputs.channels.push_back(CR_PACK(Unsigned(channel), Unsigned(channels_.range), reference_));
    }
    return inputs;
  }

  AnalogReading OfScan() {
    const AnalogScan::Scan scan = scan_->Collect();
    auto code = scan.codes.begin();
    const auto volts = [&](int channel) {
      if (channel < 0) return std::numeric_limits<double>::quiet_NaN();
      return board_.api().to_phys(*code++, in_.range, in_.maxdata);
    };
    AnalogReading reading;
    reading.um_v = volts(channels_.um);
    reading.ua_v = volts(channels_.ua);
    reading.ia_v = volts(channels_.ia);
    reading.middle_after_s = scan.middle_after_s;
    return reading;
  }

  double ReadVolts(int channel) {
    if (channel < 0) return std::numeric_limits<double>::quiet_NaN();
    lsampl_t code = 0;
    const int status = board_.api().data_read(board_.device(),
                                              Unsigned(channels_.analog_in),
                                              Unsigned(channel),
                                              Unsigned(channels_.range),
                                              reference_,
                                              &code);
    if (status < 0) board_.Fail("comedi_data_read of channel " + std::to_string(channel));
    return board_.api().to_phys(code, in_.range, in_.maxdata);
  }

  const ComediChannels channels_;
  const ComediBoard board_;
  const unsigned reference_;
  Scale in_;
  Scale out_;
  Time drive_at_{};
  std::optional<RelayPorts> relays_;
  std::optional<PulseCounter> counter_;
  std::unique_ptr<AnalogScan> scan_;  ///< null: single reads
};

}  // namespace

std::unique_ptr<Daq> OpenComedi(const ComediChannels& channels) {
  return std::make_unique<Comedi>(channels);
}

}  // namespace faultlab::hardware

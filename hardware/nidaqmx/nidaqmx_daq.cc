#include "hardware/nidaqmx/nidaqmx_daq.h"

#include <array>
#include <limits>

#include "hardware/nidaqmx/nidaqmx_api.h"

namespace faultlab::hardware {
namespace nidaqmx {

Api::Api(const SharedLibrary& library) {
  library.Find("DAQmxCreateTask", CreateTask);
  library.Find("DAQmxCreateAIVoltageChan", CreateAIVoltageChan);
  library.Find("DAQmxCreateAOVoltageChan", CreateAOVoltageChan);
  library.Find("DAQmxCreateDOChan", CreateDOChan);
  library.Find("DAQmxCreateCIFreqChan", CreateCIFreqChan);
  library.Find("DAQmxCreateCICountEdgesChan", CreateCICountEdgesChan);
  library.Find("DAQmxCreateCIAngEncoderChan", CreateCIAngEncoderChan);
  library.Find("DAQmxStartTask", StartTask);
  library.Find("DAQmxStopTask", StopTask);
  library.Find("DAQmxClearTask", ClearTask);
  library.Find("DAQmxWriteAnalogScalarF64", WriteAnalogScalarF64);
  library.Find("DAQmxReadAnalogF64", ReadAnalogF64);
  library.Find("DAQmxWriteDigitalScalarU32", WriteDigitalScalarU32);
  library.Find("DAQmxReadDigitalScalarU32", ReadDigitalScalarU32);
  library.Find("DAQmxReadCounterScalarF64", ReadCounterScalarF64);
  library.Find("DAQmxReadCounterScalarU32", ReadCounterScalarU32);
  library.Find("DAQmxCreateWatchdogTimerTaskEx", CreateWatchdogTimerTaskEx);
  library.Find("DAQmxCfgWatchdogAOExpirStates", CfgWatchdogAOExpirStates);
  library.Find("DAQmxControlWatchdogTask", ControlWatchdogTask);
  library.Find("DAQmxGetExtendedErrorInfo", GetExtendedErrorInfo);
}

}  // namespace nidaqmx

namespace {

using nidaqmx::Api;
using nidaqmx::TaskHandle;

constexpr double kRangeV = 10.0;
/// Well inside a tick: a driver that does not answer must not hold the loop.
constexpr double kTimeoutS = 0.005;
/// An encoder slower than this stands still: 0.5 rpm behind the gear.
constexpr double kPulseTimeoutS = 0.002;
constexpr double kPulseHzMin = 500.0;
constexpr double kPulseHzMax = 1e6;

/// One task of the driver, cleared at its end.
class Task {
 public:
  Task(const Api& api, const char* name) : api_(api), name_(name) {
    Check(api_.CreateTask(name, &handle_), "DAQmxCreateTask");
  }
  /// A watchdog of the device.
  Task(const Api& api, const char* name, const std::string& device, double timeout_s)
      : api_(api), name_(name) {
    Check(api_.CreateWatchdogTimerTaskEx(device.c_str(), name, &handle_, timeout_s),
          "DAQmxCreateWatchdogTimerTaskEx");
  }
  ~Task() {
    if (handle_ != nullptr) (void)api_.ClearTask(handle_);
  }
  Task(const Task&) = delete;
  Task& operator=(const Task&) = delete;

  TaskHandle handle() const { return handle_; }

  /// Negative is an error, positive a warning.
  void Check(std::int32_t status, const char* call) const {
    if (status >= 0) return;
    std::array<char, 1024> text{};
    (void)api_.GetExtendedErrorInfo(text.data(), static_cast<std::uint32_t>(text.size()));
    throw IoError(std::string(call) + " (" + name_ + ") failed with " + std::to_string(status) +
                  ": " + text.data());
  }

 private:
  const Api& api_;
  const std::string name_;
  TaskHandle handle_ = nullptr;
};

std::int32_t TerminalConfig(const std::string& terminal) {
  return terminal == "diff" ? nidaqmx::kDiff : terminal == "nrse" ? nidaqmx::kNrse : nidaqmx::kRse;
}

class NiDaqmx final : public Daq {
 public:
  NiDaqmx(const NiDaqmxChannels& channels, SpeedMethod speed)
      : channels_(channels),
        library_(channels.library),
        api_(library_),
        drive_(api_, "faultlab_drive"),
        analog_(api_, "faultlab_analog"),
        relays_(api_, "faultlab_relays") {
    drive_.Check(api_.CreateAOVoltageChan(drive_.handle(),
                                          channels.drive.c_str(),
                                          "uc",
                                          -kRangeV,
                                          kRangeV,
                                          nidaqmx::kVolts,
                                          nullptr),
                 "DAQmxCreateAOVoltageChan");
    AddInput(channels.um, "um");
    if (!channels.ua.empty()) AddInput(channels.ua, "ua");
    if (!channels.ia.empty()) AddInput(channels.ia, "ia");
    relays_.Check(
        api_.CreateDOChan(
            relays_.handle(), channels.relays.c_str(), "relays", nidaqmx::kChanForAllLines),
        "DAQmxCreateDOChan");
    for (Task* task : {&drive_, &analog_, &relays_}) {
      task->Check(api_.StartTask(task->handle()), "DAQmxStartTask");
    }
    if (!channels.counter.empty()) OpenCounter(speed);
    if (!channels.watchdog.empty()) OpenWatchdog();
  }

  double WriteDrive(double terminal_v) override {
    // One that has expired between two runs refuses writes; drive 0 must always get through.
    if (watchdog_ && terminal_v == 0.0) Watchdog(nidaqmx::kClearExpiration);
    drive_.Check(api_.WriteAnalogScalarF64(drive_.handle(), 0, kTimeoutS, terminal_v, nullptr),
                 "DAQmxWriteAnalogScalarF64");
    return terminal_v;
  }

  AnalogReading ReadAnalog() override {
    std::array<double, 3> values{};
    std::int32_t read = 0;
    analog_.Check(api_.ReadAnalogF64(analog_.handle(),
                                     1,
                                     kTimeoutS,
                                     nidaqmx::kGroupByScanNumber,
                                     values.data(),
                                     static_cast<std::uint32_t>(inputs_),
                                     &read,
                                     nullptr),
                  "DAQmxReadAnalogF64");
    if (read != 1) throw IoError("DAQmxReadAnalogF64 gave no sample");
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    std::size_t next = 1;
    AnalogReading reading{.um_v = values[0], .ua_v = kNone, .ia_v = kNone};
    if (!channels_.ua.empty()) reading.ua_v = values[next++];
    if (!channels_.ia.empty()) reading.ia_v = values[next];
    return reading;
  }

  void WriteRelayLines(std::uint32_t levels) override {
    relays_.Check(api_.WriteDigitalScalarU32(relays_.handle(), 0, kTimeoutS, levels, nullptr),
                  "DAQmxWriteDigitalScalarU32");
  }

  std::uint32_t ReadRelayLines() override {
    std::uint32_t levels = 0;
    relays_.Check(api_.ReadDigitalScalarU32(relays_.handle(), kTimeoutS, &levels, nullptr),
                  "DAQmxReadDigitalScalarU32");
    return levels;
  }

  double ReadPulseFrequencyHz() override {
    double frequency_hz = 0.0;
    const std::int32_t status =
        api_.ReadCounterScalarF64(counter().handle(), kPulseTimeoutS, &frequency_hz, nullptr);
    if (status == nidaqmx::kErrorTimeout) return 0.0;  // no pulse came: it stands
    counter().Check(status, "DAQmxReadCounterScalarF64");
    return frequency_hz;
  }

  std::uint32_t ReadPulseCount() override {
    std::uint32_t count = 0;
    counter().Check(api_.ReadCounterScalarU32(counter().handle(), kTimeoutS, &count, nullptr),
                    "DAQmxReadCounterScalarU32");
    return count;
  }

  void Prepare() override {}
  void FeedWatchdog() override {
    if (watchdog_) Watchdog(nidaqmx::kResetTimer);
  }
  bool has_watchdog() const override { return watchdog_ != nullptr; }

 private:
  /// The device itself puts the drive to 0 V when nobody has fed it for watchdog_s. The relays stay
  /// as they are: without drive no position is harmful, and a switching all at once would open R12.
  void OpenWatchdog() {
    watchdog_ =
        std::make_unique<Task>(api_, "faultlab_watchdog", channels_.watchdog, channels_.watchdog_s);
    const double zero_v = 0.0;
    const std::int32_t type = nidaqmx::kOutputVoltage;
    watchdog_->Check(api_.CfgWatchdogAOExpirStates(
                         watchdog_->handle(), channels_.drive.c_str(), &zero_v, &type, 1),
                     "DAQmxCfgWatchdogAOExpirStates");
    watchdog_->Check(api_.StartTask(watchdog_->handle()), "DAQmxStartTask");
  }

  void Watchdog(std::int32_t action) {
    watchdog_->Check(api_.ControlWatchdogTask(watchdog_->handle(), action),
                     "DAQmxControlWatchdogTask");
  }

  void AddInput(const std::string& channel, const char* name) {
    analog_.Check(api_.CreateAIVoltageChan(analog_.handle(),
                                           channel.c_str(),
                                           name,
                                           TerminalConfig(channels_.terminal),
                                           -kRangeV,
                                           kRangeV,
                                           nidaqmx::kVolts,
                                           nullptr),
                  "DAQmxCreateAIVoltageChan");
    ++inputs_;
  }

  void OpenCounter(SpeedMethod speed) {
    counter_ = std::make_unique<Task>(api_, "faultlab_counter");
    if (channels_.quadrature) {
      // Counts below 0 come as 2^32 - 1 and so on: a difference has its sign.
      constexpr std::uint32_t kAnyNumber = 1;  // of no effect on ticks
      counter_->Check(api_.CreateCIAngEncoderChan(counter_->handle(),
                                                  channels_.counter.c_str(),
                                                  "n",
                                                  nidaqmx::kX4,
                                                  0,
                                                  0.0,
                                                  nidaqmx::kAHighBHigh,
                                                  nidaqmx::kTicks,
                                                  kAnyNumber,
                                                  0.0,
                                                  nullptr),
                      "DAQmxCreateCIAngEncoderChan");
    } else if (speed == SpeedMethod::kGatedCount) {
      counter_->Check(api_.CreateCICountEdgesChan(counter_->handle(),
                                                  channels_.counter.c_str(),
                                                  "n",
                                                  nidaqmx::kRising,
                                                  0,
                                                  nidaqmx::kCountUp),
                      "DAQmxCreateCICountEdgesChan");
    } else {
      counter_->Check(api_.CreateCIFreqChan(counter_->handle(),
                                            channels_.counter.c_str(),
                                            "n",
                                            kPulseHzMin,
                                            kPulseHzMax,
                                            nidaqmx::kHz,
                                            nidaqmx::kRising,
                                            nidaqmx::kLowFreq1Ctr,
                                            0.0,
                                            1,
                                            nullptr),
                      "DAQmxCreateCIFreqChan");
    }
    counter_->Check(api_.StartTask(counter_->handle()), "DAQmxStartTask");
  }

  Task& counter() {
    if (!counter_) throw IoError("this bench has no counter");
    return *counter_;
  }

  const NiDaqmxChannels channels_;
  const SharedLibrary library_;
  const Api api_;
  Task drive_;
  Task analog_;
  Task relays_;
  std::unique_ptr<Task> counter_;
  std::unique_ptr<Task> watchdog_;
  std::size_t inputs_ = 0;
};

}  // namespace

std::unique_ptr<Daq> OpenNiDaqmx(const NiDaqmxChannels& channels, SpeedMethod speed) {
  return std::make_unique<NiDaqmx>(channels, speed);
}

}  // namespace faultlab::hardware

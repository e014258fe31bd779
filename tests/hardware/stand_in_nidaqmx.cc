// A stand-in for libnidaqmx: the real signatures, answers from the plant, checks of order and
// arguments, errors on demand.
#include <cmath>
#include <cstring>
#include <map>
#include <string>

#include "hardware/nidaqmx/nidaqmx_api.h"
#include "tests/hardware/stand_in_plant.h"

namespace {

using namespace faultlab::hardware;
using nidaqmx::Bool32;
using nidaqmx::TaskHandle;

enum class Kind {
  kNone,
  kAnalogIn,
  kAnalogOut,
  kDigitalOut,
  kFrequency,
  kCount,
  kEncoder,
  kWatchdog
};

struct Task {
  Kind kind = Kind::kNone;
  int channels = 0;
  bool started = false;
};

StandInPlant plant;
std::map<TaskHandle, Task> tasks;
std::intptr_t next_handle = 1;

constexpr std::int32_t kInjected = -50405;  // "no transfer in progress"; any error is suitable
constexpr std::int32_t kInvalidTask = -200088;
constexpr std::int32_t kBadChannel = -200170;

#define STAND_IN_CALL() \
  if (plant.Called()) return kInjected

Task* Find(TaskHandle handle) {
  const auto found = tasks.find(handle);
  if (found == tasks.end()) plant.Misuse("a task that does not exist");
  return found == tasks.end() ? nullptr : &found->second;
}

Task* Running(TaskHandle handle, Kind kind) {
  Task* task = Find(handle);
  if (task == nullptr) return nullptr;
  if (task->kind != kind) plant.Misuse("a task of another kind");
  if (!task->started) plant.Misuse("a task that was not started");
  return task->kind == kind && task->started ? task : nullptr;
}

std::int32_t AddChannel(TaskHandle handle, Kind kind, const char* channel, const char* expected) {
  Task* task = Find(handle);
  if (task == nullptr) return kInvalidTask;
  if (task->kind != Kind::kNone && task->kind != kind) plant.Misuse("two kinds in one task");
  if (task->started) plant.Misuse("a channel added to a running task");
  if (std::strstr(channel, expected) == nullptr) return kBadChannel;
  task->kind = kind;
  ++task->channels;
  return 0;
}

}  // namespace

extern "C" {

StandInControl* stand_in_control() {
  return &plant.control;
}

std::int32_t DAQmxCreateTask(const char name[], TaskHandle* task) {
  STAND_IN_CALL();
  if (name == nullptr || name[0] == '\0') plant.Misuse("a task without a name");
  *task = reinterpret_cast<TaskHandle>(next_handle++);
  tasks[*task] = {};
  ++plant.control.open_handles;
  return 0;
}

std::int32_t DAQmxCreateAIVoltageChan(TaskHandle task,
                                      const char channel[],
                                      const char[],
                                      std::int32_t terminal,
                                      double min,
                                      double max,
                                      std::int32_t units,
                                      const char[]) {
  STAND_IN_CALL();
  if (terminal != nidaqmx::kRse && terminal != nidaqmx::kDiff && terminal != nidaqmx::kNrse) {
    plant.Misuse("terminal configuration");
  }
  if (min != -10.0 || max != 10.0 || units != nidaqmx::kVolts) plant.Misuse("range of AI");
  return AddChannel(task, Kind::kAnalogIn, channel, "/ai");
}

std::int32_t DAQmxCreateAOVoltageChan(TaskHandle task,
                                      const char channel[],
                                      const char[],
                                      double min,
                                      double max,
                                      std::int32_t units,
                                      const char[]) {
  STAND_IN_CALL();
  if (min != -10.0 || max != 10.0 || units != nidaqmx::kVolts) plant.Misuse("range of AO");
  return AddChannel(task, Kind::kAnalogOut, channel, "/ao");
}

std::int32_t DAQmxCreateDOChan(TaskHandle task,
                               const char lines[],
                               const char[],
                               std::int32_t grouping) {
  STAND_IN_CALL();
  if (grouping != nidaqmx::kChanForAllLines) plant.Misuse("grouping of DO");
  return AddChannel(task, Kind::kDigitalOut, lines, "/port");
}

std::int32_t DAQmxCreateCIFreqChan(TaskHandle task,
                                   const char counter[],
                                   const char[],
                                   double min,
                                   double max,
                                   std::int32_t units,
                                   std::int32_t edge,
                                   std::int32_t method,
                                   double,
                                   std::uint32_t,
                                   const char[]) {
  STAND_IN_CALL();
  if (!(min > 0.0 && max > min) || units != nidaqmx::kHz || edge != nidaqmx::kRising ||
      method != nidaqmx::kLowFreq1Ctr) {
    plant.Misuse("arguments of CIFreq");
  }
  return AddChannel(task, Kind::kFrequency, counter, "/ctr");
}

std::int32_t DAQmxCreateCICountEdgesChan(TaskHandle task,
                                         const char counter[],
                                         const char[],
                                         std::int32_t edge,
                                         std::uint32_t initial,
                                         std::int32_t direction) {
  STAND_IN_CALL();
  if (edge != nidaqmx::kRising || initial != 0 || direction != nidaqmx::kCountUp) {
    plant.Misuse("arguments of CICountEdges");
  }
  return AddChannel(task, Kind::kCount, counter, "/ctr");
}

std::int32_t DAQmxCreateCIAngEncoderChan(TaskHandle task,
                                         const char counter[],
                                         const char[],
                                         std::int32_t decoding,
                                         Bool32 index_enable,
                                         double,
                                         std::int32_t,
                                         std::int32_t units,
                                         std::uint32_t pulses_per_revolution,
                                         double initial_angle,
                                         const char[]) {
  STAND_IN_CALL();
  if (decoding != nidaqmx::kX4 || index_enable != 0 || units != nidaqmx::kTicks ||
      pulses_per_revolution == 0 || initial_angle != 0.0) {
    plant.Misuse("arguments of CIAngEncoder");
  }
  return AddChannel(task, Kind::kEncoder, counter, "/ctr");
}

std::int32_t DAQmxStartTask(TaskHandle handle) {
  STAND_IN_CALL();
  Task* task = Find(handle);
  if (task == nullptr) return kInvalidTask;
  if (task->channels == 0) plant.Misuse("a task without channels was started");
  if (task->started) plant.Misuse("a task was started twice");
  task->started = true;
  return 0;
}

std::int32_t DAQmxStopTask(TaskHandle handle) {
  STAND_IN_CALL();
  Task* task = Find(handle);
  if (task == nullptr) return kInvalidTask;
  task->started = false;
  return 0;
}

std::int32_t DAQmxClearTask(TaskHandle handle) {
  STAND_IN_CALL();
  if (tasks.erase(handle) == 0) {
    plant.Misuse("a task was cleared twice");
    return kInvalidTask;
  }
  --plant.control.open_handles;
  return 0;
}

std::int32_t DAQmxWriteAnalogScalarF64(
    TaskHandle handle, Bool32, double timeout, double value, Bool32* reserved) {
  STAND_IN_CALL();
  if (Running(handle, Kind::kAnalogOut) == nullptr) return kInvalidTask;
  if (!(timeout > 0.0 && timeout < 0.01) || reserved != nullptr) plant.Misuse("AO write");
  if (!(std::abs(value) <= 10.0)) return kBadChannel;
  plant.Drive(value);
  return 0;
}

std::int32_t DAQmxReadAnalogF64(TaskHandle handle,
                                std::int32_t samples,
                                double timeout,
                                Bool32 fill,
                                double values[],
                                std::uint32_t size,
                                std::int32_t* read,
                                Bool32* reserved) {
  STAND_IN_CALL();
  const Task* task = Running(handle, Kind::kAnalogIn);
  if (task == nullptr) return kInvalidTask;
  if (samples != 1 || fill != nidaqmx::kGroupByScanNumber || reserved != nullptr ||
      !(timeout > 0.0 && timeout < 0.01) || size != static_cast<std::uint32_t>(task->channels)) {
    plant.Misuse("AI read");
  }
  const AnalogReading reading = plant.daq().ReadAnalog();
  const double all[3] = {reading.um_v, reading.ua_v, reading.ia_v};
  for (std::uint32_t i = 0; i < size && i < 3; ++i) values[i] = all[i];
  *read = 1;
  return 0;
}

std::int32_t DAQmxWriteDigitalScalarU32(
    TaskHandle handle, Bool32, double, std::uint32_t value, Bool32*) {
  STAND_IN_CALL();
  if (Running(handle, Kind::kDigitalOut) == nullptr) return kInvalidTask;
  plant.Relays(value);
  return 0;
}

std::int32_t DAQmxReadDigitalScalarU32(TaskHandle handle, double, std::uint32_t* value, Bool32*) {
  STAND_IN_CALL();
  if (Running(handle, Kind::kDigitalOut) == nullptr) return kInvalidTask;
  *value = plant.daq().ReadRelayLines();
  return 0;
}

std::int32_t DAQmxReadCounterScalarF64(TaskHandle handle, double, double* value, Bool32*) {
  STAND_IN_CALL();
  if (Running(handle, Kind::kFrequency) == nullptr) return kInvalidTask;
  *value = plant.daq().ReadPulseFrequencyHz();
  return *value == 0.0 ? nidaqmx::kErrorTimeout : 0;
}

std::int32_t DAQmxReadCounterScalarU32(TaskHandle handle, double, std::uint32_t* value, Bool32*) {
  STAND_IN_CALL();
  const bool encoder = Find(handle) != nullptr && Find(handle)->kind == Kind::kEncoder;
  if (Running(handle, encoder ? Kind::kEncoder : Kind::kCount) == nullptr) return kInvalidTask;
  *value = plant.daq().ReadPulseCount();
  if (encoder) {
    // Each edge of both channels, below 0 as 2^32 - 1 and so on.
    const std::uint32_t counts = 4 * *value;
    *value = plant.control.swapped ? 0 - counts : counts;
  }
  return 0;
}

std::int32_t DAQmxCreateWatchdogTimerTaskEx(const char device[],
                                            const char name[],
                                            TaskHandle* task,
                                            double timeout_s) {
  STAND_IN_CALL();
  if (device == nullptr || device[0] == '\0' || name == nullptr) plant.Misuse("watchdog's device");
  if (!(timeout_s >= 0.02)) plant.Misuse("watchdog's time");
  *task = reinterpret_cast<TaskHandle>(next_handle++);
  tasks[*task] = {.kind = Kind::kWatchdog};
  ++plant.control.open_handles;
  plant.control.watchdog_s = timeout_s;
  return 0;
}

std::int32_t DAQmxCfgWatchdogAOExpirStates(TaskHandle handle,
                                           const char channels[],
                                           const double states[],
                                           const std::int32_t output_types[],
                                           std::uint32_t size) {
  STAND_IN_CALL();
  Task* task = Find(handle);
  if (task == nullptr || task->kind != Kind::kWatchdog) return kInvalidTask;
  if (task->started) plant.Misuse("expiration states after the start");
  if (size != 1 || states[0] != 0.0 || output_types[0] != nidaqmx::kOutputVoltage ||
      std::strstr(channels, "/ao") == nullptr) {
    plant.Misuse("expiration states");
  }
  ++task->channels;
  return 0;
}

std::int32_t DAQmxControlWatchdogTask(TaskHandle handle, std::int32_t action) {
  STAND_IN_CALL();
  if (Running(handle, Kind::kWatchdog) == nullptr) return kInvalidTask;
  if (action == nidaqmx::kResetTimer) ++plant.control.watchdog_fed;
  if (action != nidaqmx::kResetTimer && action != nidaqmx::kClearExpiration) {
    plant.Misuse("watchdog action");
  }
  return 0;
}

std::int32_t DAQmxGetExtendedErrorInfo(char text[], std::uint32_t size) {
  std::snprintf(text, size, "the stand-in was told to fail");
  return 0;
}

}  // extern "C"

#pragma once

#include <cstdint>

#include "hardware/daq/shared_library.h"

namespace faultlab::hardware::nidaqmx {

/// The part of NI-DAQmx's C API that a bench needs, declared here because the driver's own header
/// comes with the driver. Names, order and types of the arguments are those of NIDAQmx.h.
using TaskHandle = void*;
using Bool32 = std::uint32_t;

inline constexpr std::int32_t kDiff = 10106;            // DAQmx_Val_Diff
inline constexpr std::int32_t kRse = 10083;             // DAQmx_Val_RSE
inline constexpr std::int32_t kNrse = 10078;            // DAQmx_Val_NRSE
inline constexpr std::int32_t kVolts = 10348;           // DAQmx_Val_Volts
inline constexpr std::int32_t kHz = 10373;              // DAQmx_Val_Hz
inline constexpr std::int32_t kRising = 10280;          // DAQmx_Val_Rising
inline constexpr std::int32_t kX4 = 10092;              // DAQmx_Val_X4
inline constexpr std::int32_t kTicks = 10304;           // DAQmx_Val_Ticks
inline constexpr std::int32_t kAHighBHigh = 10040;      // DAQmx_Val_AHighBHigh
inline constexpr std::int32_t kLowFreq1Ctr = 10105;     // DAQmx_Val_LowFreq1Ctr
inline constexpr std::int32_t kCountUp = 10128;         // DAQmx_Val_CountUp
inline constexpr std::int32_t kChanForAllLines = 1;     // DAQmx_Val_ChanForAllLines
inline constexpr Bool32 kGroupByScanNumber = 1;         // DAQmx_Val_GroupByScanNumber
inline constexpr std::int32_t kErrorTimeout = -200284;  // DAQmxErrorSamplesNotYetAvailable

inline constexpr std::int32_t kOutputVoltage = 10322;  // DAQmx_Val_Voltage
inline constexpr std::int32_t kResetTimer = 0;         // DAQmx_Val_ResetTimer
inline constexpr std::int32_t kClearExpiration = 1;    // DAQmx_Val_ClearExpiration

struct Api {
  explicit Api(const SharedLibrary& library);

  std::int32_t (*CreateTask)(const char name[], TaskHandle* task);
  std::int32_t (*CreateAIVoltageChan)(TaskHandle task,
                                      const char physical_channel[],
                                      const char name[],
                                      std::int32_t terminal_config,
                                      double min,
                                      double max,
                                      std::int32_t units,
                                      const char custom_scale[]);
  std::int32_t (*CreateAOVoltageChan)(TaskHandle task,
                                      const char physical_channel[],
                                      const char name[],
                                      double min,
                                      double max,
                                      std::int32_t units,
                                      const char custom_scale[]);
  std::int32_t (*CreateDOChan)(TaskHandle task,
                               const char lines[],
                               const char name[],
                               std::int32_t line_grouping);
  std::int32_t (*CreateCIFreqChan)(TaskHandle task,
                                   const char counter[],
                                   const char name[],
                                   double min,
                                   double max,
                                   std::int32_t units,
                                   std::int32_t edge,
                                   std::int32_t method,
                                   double measurement_time,
                                   std::uint32_t divisor,
                                   const char custom_scale[]);
  std::int32_t (*CreateCICountEdgesChan)(TaskHandle task,
                                         const char counter[],
                                         const char name[],
                                         std::int32_t edge,
                                         std::uint32_t initial_count,
                                         std::int32_t direction);
  std::int32_t (*CreateCIAngEncoderChan)(TaskHandle task,
                                         const char counter[],
                                         const char name[],
                                         std::int32_t decoding,
                                         Bool32 index_enable,
                                         double index_value,
                                         std::int32_t index_phase,
                                         std::int32_t units,
                                         std::uint32_t pulses_per_revolution,
                                         double initial_angle,
                                         const char custom_scale[]);
  std::int32_t (*StartTask)(TaskHandle task);
  std::int32_t (*StopTask)(TaskHandle task);
  std::int32_t (*ClearTask)(TaskHandle task);
  std::int32_t (*WriteAnalogScalarF64)(
      TaskHandle task, Bool32 auto_start, double timeout, double value, Bool32* reserved);
  std::int32_t (*ReadAnalogF64)(TaskHandle task,
                                std::int32_t samples_per_channel,
                                double timeout,
                                Bool32 fill_mode,
                                double values[],
                                std::uint32_t size,
                                std::int32_t* samples_read,
                                Bool32* reserved);
  std::int32_t (*WriteDigitalScalarU32)(
      TaskHandle task, Bool32 auto_start, double timeout, std::uint32_t value, Bool32* reserved);
  std::int32_t (*ReadDigitalScalarU32)(TaskHandle task,
                                       double timeout,
                                       std::uint32_t* value,
                                       Bool32* reserved);
  std::int32_t (*ReadCounterScalarF64)(TaskHandle task,
                                       double timeout,
                                       double* value,
                                       Bool32* reserved);
  std::int32_t (*ReadCounterScalarU32)(TaskHandle task,
                                       double timeout,
                                       std::uint32_t* value,
                                       Bool32* reserved);
  std::int32_t (*CreateWatchdogTimerTaskEx)(const char device[],
                                            const char name[],
                                            TaskHandle* task,
                                            double timeout_s);
  std::int32_t (*CfgWatchdogAOExpirStates)(TaskHandle task,
                                           const char channels[],
                                           const double states[],
                                           const std::int32_t output_types[],
                                           std::uint32_t size);
  std::int32_t (*ControlWatchdogTask)(TaskHandle task, std::int32_t action);
  std::int32_t (*GetExtendedErrorInfo)(char text[], std::uint32_t size);
};

}  // namespace faultlab::hardware::nidaqmx

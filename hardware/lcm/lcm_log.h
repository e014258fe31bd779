#pragma once

#include <cstdint>
#include <istream>
#include <string>
#include <vector>

#include "core/types/result.h"
#include "core/types/sample.h"
#include "hardware/rig.h"

namespace faultlab::hardware {

/// One run out of an LCM log.
struct LcmRecord {
  std::string rig;
  std::string run;
  std::vector<core::Sample> samples;  ///< by index, without doubles
  std::vector<RigEvent> events;
  std::int64_t lost_samples = 0;  ///< holes in the sequence of the bus
};

/// Reads what lcm-logger wrote of a tap. With an empty `run` the first run in the log is taken;
/// events name components of `bench`. kNotFound when the file or the run is not there, kInvalid for
/// samples that cannot be decoded and for events with lengths that no log has.
core::Result<LcmRecord> ReadLcmLog(const std::string& path,
                                   const std::string& run,
                                   const core::Bench& bench);
/// The same of bytes that are there already; `path` names them in errors.
core::Result<LcmRecord> ReadLcmLog(std::istream& in,
                                   const std::string& path,
                                   const std::string& run,
                                   const core::Bench& bench);

/// Writes a recording as the log that lcm-logger would have made of its tap, for lcm-logplayer.
/// `begun_unix_us` is the start of the run. An existing file is replaced.
core::Status WriteLcmLog(const std::string& path,
                         const LcmRecord& record,
                         std::int64_t begun_unix_us);

}  // namespace faultlab::hardware

#pragma once

#include <cstdint>
#include <functional>
#include <istream>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/types/result.h"
#include "core/types/sample.h"
#include "hardware/rig.h"

namespace faultlab::hardware {

/// What a log holds that is not in the record made of it, in messages.
struct LcmSkipped {
  std::map<std::string, std::int64_t> channels;   ///< that carry neither samples nor events
  std::map<std::string, std::int64_t> undecoded;  ///< by channel: damaged, or of another type
  std::int64_t other_runs = 0;
  std::int64_t unknown_events = 0;  ///< of a kind or component that is not known here

  /// A sentence each, for a person: "3000 messages of channel FAULTLAB.sim-1.ESTIMATES skipped:
  /// ..". Channels beyond the first ten are counted together. Empty: nothing was skipped.
  std::vector<std::string> Sentences() const;
};

/// One run out of an LCM log.
struct LcmRecord {
  std::string rig;
  std::string run;
  std::vector<core::Sample> samples;  ///< by index, without doubles
  std::vector<RigEvent> events;
  std::int64_t lost_samples = 0;  ///< holes in the sequence of the bus
  LcmSkipped skipped{};
};

/// Reads what lcm-logger wrote of a tap. With an empty `run` the first run in the log is taken;
/// events name components of `bench`. What cannot be decoded is skipped and counted. kNotFound when
/// the file or the run is not there; kInvalid for an event of the log with lengths that no log has.
core::Result<LcmRecord> ReadLcmLog(const std::string& path,
                                   const std::string& run,
                                   const core::Bench& bench);
/// The same of bytes that are there already; `path` names them in errors.
core::Result<LcmRecord> ReadLcmLog(std::istream& in,
                                   const std::string& path,
                                   const std::string& run,
                                   const core::Bench& bench);

/// A recording as the log that lcm-logger would have made of its tap, for lcm-logplayer, in pieces.
/// `begun_unix_us` is the start of the run. Contract: IsRigName(record.rig).
void FormatLcmLog(const LcmRecord& record,
                  std::int64_t begun_unix_us,
                  const std::function<void(std::string_view)>& take);
/// The same as a file, whole or not at all. An existing file is replaced.
core::Status WriteLcmLog(const std::string& path,
                         const LcmRecord& record,
                         std::int64_t begun_unix_us);

}  // namespace faultlab::hardware

#pragma once

#include <string>
#include <vector>

#include "core/types/fault.h"
#include "core/types/result.h"
#include "core/types/sample.h"

namespace faultlab::server {

/// A recording with what is known of its making.
struct SourceRecording {
  std::string name;
  std::vector<core::Sample> samples;
  double period_s = 0.0;
  std::vector<core::Fault> faults;  ///< injected, as far as the recording says
  std::vector<std::string> notes;
};

/// `recording` is a CSV file if there is one of that name or it ends in .csv or .csv.gz, else the
/// id of a run stored below `data_dir`.
core::Result<SourceRecording> LoadRecording(const std::string& recording,
                                            const std::string& data_dir);

}  // namespace faultlab::server

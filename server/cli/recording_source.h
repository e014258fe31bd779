#pragma once

#include <string>
#include <vector>

#include "core/bench/bench.h"
#include "core/types/fault.h"
#include "core/types/result.h"
#include "core/types/sample.h"
#include "server/csv/bench_comment.h"

namespace faultlab::server {

/// A recording with what is known about its origin.
struct SourceRecording {
  std::string name;
  const core::Bench* bench = nullptr;  ///< of a stored run its own, else as asked
  NamedBench bench_named;              ///< in the comments of a file
  std::vector<core::Sample> samples;
  double period_s = 0.0;
  std::vector<core::Fault> faults;  ///< the injected faults, if the recording contains them
  std::vector<std::string> notes;
};

/// The recordings in a folder, sorted by name; kNotFound when there is none.
core::Result<std::vector<std::string>> RecordingsIn(const std::string& folder);

/// `recording` is a CSV file if a file of that name exists or it ends in .csv or .csv.gz; otherwise
/// it is the id of a run stored in `data_dir`.
core::Result<SourceRecording> LoadRecording(const std::string& recording,
                                            const std::string& data_dir,
                                            const core::Bench& bench);

}  // namespace faultlab::server

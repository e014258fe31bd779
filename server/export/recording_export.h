#pragma once

#include <boost/json/value.hpp>
#include <span>
#include <string>
#include <vector>

#include "core/types/fault.h"
#include "core/types/frame.h"
#include "core/types/sample.h"

namespace faultlab::server {

/// A recording as it leaves the laboratory. Frames may be empty (no estimates are exported then);
/// otherwise one for each sample.
struct RecordingExport {
  std::string name;
  std::string origin;  ///< rig, run id, version: one line
  double period_s = 0.0;
  std::span<const core::Sample> samples;
  std::span<const core::Frame> frames;
  std::vector<core::Fault> faults;
  boost::json::value diagnosis;  ///< object of `diagnose --json`, or null
};

/// CSV as `faultlab diagnose` reads it; name, origin and faults are comments.
std::string ExportCsv(const RecordingExport& recording);

/// {"name","origin","period_s","faults":[..],"samples":{"index":[],"t_s":[],..},"estimates":
/// {"swa_50":{"theta":[[b0d,b1d,a1d],..],"sigma":[..],"status":[..]},..},"diagnosis"}
std::string ExportJson(const RecordingExport& recording);

/// MATLAB level 5: columns t_s, uc_v, um_v, ua_v, ia_a, n_rpm and sample_index, scalar period_s;
/// per estimator an n x 3 matrix (swa_100: b0d b1d a1d; sia_100_20: b0 b1 a1), its standard errors
/// (swa_100_sigma) and status (swa_100_status: 0 excited, 1 weak, 2 not excited, 3 invalid); texts
/// name, origin, diagnosis_json. A lost number is NaN.
std::string ExportMat(const RecordingExport& recording);

}  // namespace faultlab::server

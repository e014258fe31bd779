#pragma once

#include <boost/json/value.hpp>
#include <functional>
#include <span>
#include <string>

#include "core/types/frame.h"
#include "core/types/sample.h"
#include "server/spool.h"

namespace faultlab::server {

/// A recording in the form in which it is exported.
struct RecordingExport {
  std::string name;
  std::string origin;  ///< rig, run id, version: one line
  std::string story;   ///< what happened, as JSON; empty: not known
  double period_s = 0.0;
  std::span<const core::Sample> samples;
  /// Calls back with the estimates at each sample, in order, so that a million frames are never in
  /// memory.
  std::function<void(const std::function<void(const core::Frame&)>&)> each_frame;
  boost::json::value diagnosis;  ///< object of `diagnose --json`, or null
};

/// MATLAB level 5: columns t_s, uc_v, um_v, ua_v, ia_a, n_rpm, delta_s and sample_index, scalar
/// period_s; per estimator an n x 3 matrix (swa_100: b0d b1d a1d; sia_100_20: b0 b1 a1), its
/// standard errors (swa_100_sigma) and status (swa_100_status: 0 excited, 1 weak, 2 not excited, 3
/// invalid); texts name, origin, story, diagnosis_json. A lost number is NaN.
void WriteMat(const RecordingExport& recording, Spool& out);

/// CSV with a row for each sample: index, t_s; per estimator its parameters (swa_100_b0d), their
/// standard errors (swa_100_b0d_sigma) and its status (swa_100_status: excited, weak, not_excited,
/// invalid). An estimate that does not exist is an empty cell. The first line is a comment.
void WriteEstimatesCsv(const RecordingExport& recording, Spool& out);

}  // namespace faultlab::server

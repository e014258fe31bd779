#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/types/frame.h"
#include "server/experiment/recordings.h"
#include "server/report/report.h"

namespace faultlab::server {

/// Run time [from, to); nothing when it is not before `to_s`.
struct Stretch {
  double from_s = 0.0;
  double to_s = 0.0;
};

/// The estimates over these are averaged to compare the rig before and after a change.
struct Stretches {
  Stretch before;
  Stretch after;
};

/// Before: the last 5 s (at least 100 samples) before the change, but not before the estimator has
/// settled after the start or the change before it. After: from when its window holds no sample
/// from before the change, up to the next change or the end. The page has the same rule
/// (web/src/live/before_after.ts); one list of cases tests both.
/// @param at_s     one of `changes`; nothing: nothing has changed, before is the end of the record
/// @param changes  all of the record
Stretches StretchesAround(std::optional<double> at_s,
                          std::span<const double> changes,
                          double end_s,
                          const core::EstimatorShape& shape,
                          double period_s);

/// The newest changes of a record with the estimates around each, at most `most`, in time order. A
/// record without a change has one entry, without a time.
std::vector<ReportChange> EstimatesAround(const Review& review, std::size_t most);

}  // namespace faultlab::server

#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/types/sample.h"
#include "server/plots/figures.h"

namespace faultlab::server {

/// One of the recordings that are drawn over each other.
struct ComparedRecord {
  std::string name;
  std::vector<core::Sample> samples;
  core::EstimatedChannel estimated = core::EstimatedChannel::kUm;  ///< of which the curve is
  EstimateCurve curve;                                             ///< of the same samples
  double zero_s = 0.0;  ///< time of the record that is drawn at 0
};

/// As many as there are pairs of ink and dash that stay apart.
inline constexpr std::size_t kComparedMax = 4;

/// The estimated signal of each record and one estimator's b0, b1 and a1, in the same panels. The
/// curves are all of `family`.
/// `aligned`: 0 is each record's change, and is marked. Throws ContractError for more than
/// kComparedMax records.
Figure MakeComparisonFigure(std::span<const ComparedRecord> records,
                            EstimatorFamily family,
                            bool aligned,
                            const std::string& footer);

}  // namespace faultlab::server

#include "core/filter/simd/lane_products.h"
#include "core/filter/simd/lane_run.h"
#include "core/filter/simd/wide_lanes.h"
#include "core/numerics/lanes.h"

namespace faultlab::core {

void RunAlone(const LaneRun& run, bool mc_response) {
  mc_response ? RunLanes<double, true>(run) : RunLanes<double, false>(run);
}

void RunTogether(const LaneRun& run, bool mc_response) {
  if (RunWideLanes(run, mc_response)) return;
  mc_response ? RunLanes<Lanes2, true>(run) : RunLanes<Lanes2, false>(run);
}

void SumProducts(const ProductRows& rows, ProductSums& sums) {
  if (!SumWideProducts(rows, sums)) SumLaneProducts<Lanes2>(rows, sums);
}

}  // namespace faultlab::core

#include "core/filter/simd/wide_lanes.h"

#include <array>
#include <cmath>

#include "core/filter/innovations.h"
#include "core/filter/prediction_model.h"
#include "core/numerics/lanes.h"
#include "core/types/check.h"

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)

// Headers included above are compiled for any x86-64. Whatever templates of the headers below are
// instantiated in this file, and with whatever lanes, is AVX2: what other processors run too
// belongs into another file (narrow_lanes.cc). The code below is instantiated in this file only,
// which is compiled for AVX2 (not for fused multiply-add, which would change the bits), and is
// called only on processors that have AVX2.
#include <algorithm>
#include <cstring>
#include <limits>
#include <span>
#pragma GCC push_options
#pragma GCC target("avx2")

namespace faultlab::core {

using Lanes4 = double __attribute__((vector_size(32)));

[[gnu::always_inline]] inline Lanes4 SquareRoot(Lanes4 values) {
  return __builtin_ia32_sqrtpd256(values);
}
[[gnu::always_inline]] inline Lanes4 Magnitude(Lanes4 values) {
  return values < 0.0 ? -values : values;
}

}  // namespace faultlab::core

#include "core/filter/simd/lane_products.h"
#include "core/filter/simd/lane_run.h"

namespace faultlab::core {

static void RunAvx2(const LaneRun& run, bool mc_response) {
  mc_response ? RunLanes<Lanes4, true>(run) : RunLanes<Lanes4, false>(run);
}

static void SumAvx2(const ProductRows& rows, ProductSums& sums) {
  SumLaneProducts<Lanes4>(rows, sums);
}

}  // namespace faultlab::core

#pragma GCC pop_options

namespace faultlab::core {

static bool HasAvx2() {
  static const bool kHas = __builtin_cpu_supports("avx2") != 0;
  return kHas;
}

bool RunWideLanes(const LaneRun& run, bool mc_response) {
  if (HasAvx2()) RunAvx2(run, mc_response);
  return HasAvx2();
}

bool SumWideProducts(const ProductRows& rows, ProductSums& sums) {
  if (HasAvx2()) SumAvx2(rows, sums);
  return HasAvx2();
}

}  // namespace faultlab::core

#else

namespace faultlab::core {

bool RunWideLanes(const LaneRun&, bool) {
  return false;
}

bool SumWideProducts(const ProductRows&, ProductSums&) {
  return false;
}

}  // namespace faultlab::core

#endif

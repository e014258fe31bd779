#include "core/filter/simd/lane_products.h"
#include "core/filter/simd/wide_lanes.h"
#include "core/numerics/lanes.h"

namespace faultlab::core {

void SumProducts(const ProductRows& rows, ProductSums& sums) {
  if (!SumWideProducts(rows, sums)) SumLaneProducts<Lanes2>(rows, sums);
}

}  // namespace faultlab::core

#pragma once

#include <vector>

#include "server/api/gate.h"
#include "server/demonstration/detection_study.h"
#include "server/experiment/benches.h"

namespace faultlab::server {

/// Recordings to learn from, and what the estimators and the detection bank make of them: for
/// everybody, the same for all.
struct DemonstrationApi {
  explicit DemonstrationApi(Benches& known) : benches(known) {}

  Benches& benches;
  DetectionStudies studies;
};

/// @param api  must outlive the routes
std::vector<ApiRoute> RoutesOf(DemonstrationApi& api);

}  // namespace faultlab::server

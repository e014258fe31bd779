#pragma once

#include <functional>
#include <string_view>

#include "server/api/gate.h"
#include "server/lab/lab_service.h"
#include "server/run/rig_pool.h"
#include "server/run/run_manager.h"
#include "server/storage/rig_calibrations.h"

// The server itself and its rigs: health, metrics, description, who am I.
namespace faultlab::server {

struct SystemApi {
  RunManager& runs;
  RigPool& rig_pool;
  StreamHub& hub;
  RigCalibrations& calibrations;
  Benches& benches;
  lab::LabService& service;
  const Clock& clock;
  std::string_view openapi;  ///< server/api/openapi.json, embedded
  std::function<HttpCounters()> http_counters;
  std::function<core::Status()> database_check;  ///< cheap: for /readyz
  MonotonicTime started;
};

std::vector<ApiRoute> RoutesOf(SystemApi& api);

}  // namespace faultlab::server

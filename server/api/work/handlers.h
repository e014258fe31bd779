#pragma once

#include <cstdint>

#include "server/api/gate.h"
#include "server/auth/accounts.h"
#include "server/auth/audit_log.h"
#include "server/experiment/experiments.h"
#include "server/fault_sets/fault_sets.h"
#include "server/jobs/job_store.h"
#include "server/lab/lab_service.h"
#include "server/storage/rig_calibrations.h"

// What is prepared for others or done without a person: fault sets, their isolability, jobs.
namespace faultlab::server {

struct WorkApi {
  Experiments& experiments;
  Recordings& recordings;
  FaultSets& fault_sets;
  FaultSetAccess& fault_set_access;
  JobStore& jobs;
  lab::LabService& service;
  Accounts& accounts;
  RigPool& rig_pool;
  RunManager& runs;
  RecordingStore& store;
  RigCalibrations& calibrations;
  Benches& benches;
  AuditLog& audit;
  const Clock& clock;
};

std::vector<ApiRoute> RoutesOf(WorkApi& api);

// jobs.cc
core::Result<HttpResponse> ListJobs(WorkApi& api, const ApiRequest& request);
core::Result<HttpResponse> CreateJobs(WorkApi& api, const ApiRequest& request);
core::Result<HttpResponse> GetJob(WorkApi& api, const ApiRequest& request);
core::Result<HttpResponse> CancelJob(WorkApi& api, const ApiRequest& request);

// sweep.cc
core::Result<HttpResponse> GetSweepPlot(WorkApi& api, const ApiRequest& request);

// fault_sets.cc
core::Result<HttpResponse> ListFaultSets(WorkApi& api, const ApiRequest& request);
core::Result<HttpResponse> CreateFaultSet(WorkApi& api, const ApiRequest& request);
core::Result<HttpResponse> ChangeFaultSet(WorkApi& api, const ApiRequest& request);
core::Result<HttpResponse> DeleteFaultSet(WorkApi& api, const ApiRequest& request);

// isolability.cc
core::Result<HttpResponse> GetIsolability(WorkApi& api, const ApiRequest& request);
core::Result<HttpResponse> GetIsolabilityPlot(WorkApi& api, const ApiRequest& request);
}  // namespace faultlab::server

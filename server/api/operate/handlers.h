#pragma once

#include "server/api/gate.h"
#include "server/auth/accounts.h"
#include "server/auth/audit_log.h"
#include "server/lab/alarms.h"
#include "server/lab/check_log.h"
#include "server/lab/lab_service.h"
#include "server/lab/relay_wear.h"
#include "server/run/rig_pool.h"

// What operators look at: the history of rigs, alarms, the queue, the effect of an outage.
namespace faultlab::server {

struct OperateApi {
  lab::LabService& service;
  Accounts& accounts;
  RigPool& rig_pool;
  lab::CheckLog& checks;
  lab::RelayWear& wear;
  lab::Alarms& alarms;
  Database& database;
  AuditLog& audit;
  const Clock& clock;
};

std::vector<ApiRoute> RoutesOf(OperateApi& api);

/// The account of a person as operators see it: {"login", "name"}; null for nobody.
boost::json::value PersonToJson(OperateApi& api, std::int64_t account);

// history.cc
core::Result<HttpResponse> GetRigHistory(OperateApi& api, const ApiRequest& request);
core::Result<HttpResponse> NoteReplacedRelay(OperateApi& api, const ApiRequest& request);

// alarms.cc
core::Result<HttpResponse> ListAlarms(OperateApi& api, const ApiRequest& request);
core::Result<HttpResponse> AcknowledgeAlarm(OperateApi& api, const ApiRequest& request);

// outlook.cc
core::Result<HttpResponse> ListQueue(OperateApi& api, const ApiRequest& request);
core::Result<HttpResponse> PreviewOutage(OperateApi& api, const ApiRequest& request);

}  // namespace faultlab::server

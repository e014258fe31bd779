#include <boost/json.hpp>

#include "server/api/operate/handlers.h"

namespace faultlab::server {

std::vector<ApiRoute> RoutesOf(OperateApi& api) {
  using enum HttpMethod;
  using enum Operation;
  using enum Guard;
  const auto on = [&api](auto handler) { return On(api, handler); };
  return {
      {kGet, "/api/v1/rigs/{id}/history", kOperateRig, kRole, on(GetRigHistory)},
      {kPost,
       "/api/v1/rigs/{id}/relays/{line}/replaced",
       kOperateRig,
       kRole,
       on(NoteReplacedRelay),
       kEmptyOnce},
      {kGet, "/api/v1/rigs/{id}/outages/preview", kOperateRig, kRole, on(PreviewOutage)},
      {kGet, "/api/v1/alarms", kOperateRig, kRole, on(ListAlarms)},
      {kPost, "/api/v1/alarms/{id}/acknowledge", kOperateRig, kRole, on(AcknowledgeAlarm), kEmpty},
      {kGet, "/api/v1/queue", kOperateRig, kRole, on(ListQueue)},
  };
}

boost::json::value PersonToJson(OperateApi& api, std::int64_t account) {
  if (account == 0) return nullptr;
  const auto found = api.accounts.Get(account);
  if (!found.ok()) return nullptr;
  return boost::json::object{{"login", found.value().login}, {"name", found.value().name}};
}

}  // namespace faultlab::server

#include "server/api/notify/handlers.h"

namespace faultlab::server {

std::vector<ApiRoute> RoutesOf(NotifyApi& api) {
  using enum HttpMethod;
  using enum Operation;
  using enum Guard;
  const auto on = [&api](auto handler) { return On(api, handler); };
  return {
      {kGet, "/api/v1/webhooks", kManageWebhooks, kRole, on(ListWebhooks)},
      {kPost, "/api/v1/webhooks", kManageWebhooks, kRole, on(CreateWebhook), kJson},
      {kDelete, "/api/v1/webhooks/{id}", kManageWebhooks, kRole, on(DeleteWebhook)},
      {kPost,
       "/api/v1/webhooks/{id}/test",
       kManageWebhooks,
       kRole,
       on(TestWebhook),
       kEmpty,
       Cost::kOutside},
  };
}

}  // namespace faultlab::server

#pragma once

#include "server/api/gate.h"
#include "server/auth/audit_log.h"
#include "server/notify/hook_sender.h"
#include "server/notify/webhooks.h"

// Who is told what, besides the page: webhooks.
namespace faultlab::server {

struct NotifyApi {
  notify::Webhooks& webhooks;
  const notify::HookSender& sender;
  AuditLog& audit;
  const Clock& clock;
};

std::vector<ApiRoute> RoutesOf(NotifyApi& api);

// webhooks.cc
core::Result<HttpResponse> ListWebhooks(NotifyApi& api, const ApiRequest& request);
core::Result<HttpResponse> CreateWebhook(NotifyApi& api, const ApiRequest& request);
core::Result<HttpResponse> DeleteWebhook(NotifyApi& api, const ApiRequest& request);
core::Result<HttpResponse> TestWebhook(NotifyApi& api, const ApiRequest& request);

}  // namespace faultlab::server

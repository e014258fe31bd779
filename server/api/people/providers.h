#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/api/gate.h"
#include "server/auth/accounts.h"
#include "server/auth/audit_log.h"
#include "server/auth/throttle.h"
#include "server/oidc/sign_in_flow.h"

// Signing in at a provider (OpenID Connect), and the providers that an account knows.
namespace faultlab::server {

struct ProvidersApi {
  ProvidersApi(Accounts& the_accounts,
               AuditLog& the_audit,
               oidc::SignInFlow& the_flow,
               const Clock& the_clock,
               std::string the_public_url,
               std::function<void(std::string_view)> the_log)
      : accounts(the_accounts),
        audit(the_audit),
        flow(the_flow),
        clock(the_clock),
        public_url(std::move(the_public_url)),
        log(std::move(the_log)) {}

  Accounts& accounts;
  AuditLog& audit;
  oidc::SignInFlow& flow;
  const Clock& clock;
  std::string public_url;  ///< "https://lab.example.org"; empty: by the request's Host
  std::function<void(std::string_view)> log;
  Throttle callbacks{20};  ///< that failed, by network: each asked the provider
  Throttle lines{20};      ///< of refusals in the log, by network
};

std::vector<ApiRoute> RoutesOf(ProvidersApi& api);

}  // namespace faultlab::server

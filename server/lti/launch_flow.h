#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/types/result.h"
#include "server/clock.h"
#include "server/lti/platform_client.h"
#include "server/oidc/login_state.h"
#include "server/oidc/provider.h"

namespace faultlab::server::lti {

/// Parameters of a query or a form, decoded.
using Form = std::vector<std::pair<std::string, std::string>>;
/// The first value of this name; empty: there is none.
std::string ValueOf(const Form& form, std::string_view name);

/// A person who came by a link of a platform.
struct Launch {
  Platform platform;
  std::string subject;  ///< that it never gives to another person
  std::string login;    ///< that it proposes; empty: none
  std::string name;     ///< for display; may be empty
  std::string state;    ///< of this one launch: it is accepted only once
  bool teaches = false;
  std::optional<std::int64_t> exercise;  ///< of the link; nullopt: of the lab as such
  std::string lineitem;                  ///< where its grades go; empty: nowhere
  std::string roster;                    ///< where its course's people are told; empty: nowhere
  /// Of a deep linking request: somebody who teaches chooses the exercise of a new link.
  struct Choice {
    std::string return_url;  ///< that takes the chosen link
    std::string data;        ///< handed back as it came
    std::string deployment;
  };
  std::optional<Choice> choice{};
};

/// LTI 1.3, the side of the tool: OpenID Connect's third-party initiated login, answered by a form
/// that the browser posts.
///
///   browser                this lab                      platform
///     |<---------------------------------------- a link is followed
///     |---- Begin ---------->| seals state, nonce            |
///     |<-- cookie, 303 ------|                               |
///     |------------------------------------- is it them? --->|
///     |<------------------------- a form: ID token, state ---|
///     |---- Finish --------->|-- keys ----------------------->|
///     |                      | Launch, or a refusal
///
/// Refusals have a `reason` for the page ("lti_elsewhere", "lti_failed", "lti_away",
/// "lti_message"); their message is for the log. Both calls block: on pool threads only.
/// Thread-safe. Source: 1EdTech Learning Tools Interoperability 1.3, Security Framework 1.0.
class LaunchFlow {
 public:
  /// @param secret  shared by the servers of a database; the others must outlive it
  LaunchFlow(Database& database,
             std::string secret,
             Reach reach,
             const PlatformClient& client,
             const Clock& clock);

  struct Departure {
    std::string location;  ///< at the platform
    std::string sealed;    ///< for the cookie
  };
  /// @param asked  of the platform's login request
  core::Result<Departure> Begin(const Form& asked, const std::string& redirect_uri);
  /// @param posted  the form; @param sealed  the cookie
  core::Result<Launch> Finish(const Form& posted, std::string_view sealed);

  /// What opens the lab in a window of its own, for 10 min, once.
  /// @param connects  as Ticket
  std::string TicketOf(const Launch& launch, const std::string& next, bool connects = false) const;
  struct Ticket {
    std::string issuer, subject, state, next;
    bool connects = false;  ///< adds this person to the account that is signed in
  };
  /// "lti_elsewhere"
  core::Result<Ticket> Open(std::string_view sealed) const;

  /// The answer to a deep linking request: a JWT with the link of this exercise, for 10 min.
  std::string LinkOf(const Launch& launch,
                     const ToolKey& key,
                     std::int64_t assignment,
                     const std::string& title,
                     const std::string& launch_url) const;
  /// What a link on a platform says of an exercise (exercise_code.h).
  std::string CodeOf(std::int64_t assignment) const;

 private:
  std::shared_ptr<oidc::Provider> ProviderOf(const Platform& platform);

  Platforms platforms_;
  const std::string secret_;
  const Reach reach_;
  const PlatformClient& client_;
  const Clock& clock_;
  const oidc::LoginSeal seal_;
  std::mutex mutex_;
  /// By their addresses: a platform that is registered anew begins anew.
  std::map<std::string, std::shared_ptr<oidc::Provider>> providers_;
};

}  // namespace faultlab::server::lti

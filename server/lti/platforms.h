#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/types/result.h"
#include "server/storage/database.h"
#include "server/wall_time.h"

namespace faultlab::server::lti {

/// A learning platform (Moodle, Canvas, ILIAS) whose launches are accepted, as an admin has
/// registered it.
struct Platform {
  std::int64_t id = 0;
  std::string label;       ///< for people: "Moodle of the faculty"
  std::string issuer;      ///< `iss`, byte for byte
  std::string client_id;   ///< that the platform has given this lab
  std::string deployment;  ///< the only one that is accepted; empty: any of this client
  std::string auth_url;    ///< OpenID Connect: where a launch is asked for
  std::string token_url;   ///< OAuth 2: where grades get their token
  std::string keys_url;    ///< JWK set of the platform
  /// An instructor of the platform who has no account here gets one that may make courses.
  bool makes_teachers = false;
  /// Accounts of class lists that nobody has used are given to the person with their login: safe
  /// only if people cannot choose their login on the platform.
  bool claims_class_lists = false;
  WallTime created{};
};

/// The name of a platform's people among external identities, and of its messages in the outbox:
/// "lti:3". Platforms that share an issuer, as hosted Canvas does, are kept apart.
std::string NameOf(std::int64_t platform);
/// nullopt: not of a platform.
std::optional<std::int64_t> PlatformOf(std::string_view name);

/// Thread-safe, stateless.
class Platforms {
 public:
  static constexpr int kMax = 50;

  explicit Platforms(Database& database) : database_(database) {}

  /// kConflict "platforms_full", "platform_known": this client of this issuer.
  core::Result<Platform> Add(Platform platform);
  /// The values of platform.id, in place of those that it had; its people and their grades stay
  /// with it. kConflict "platform_issuer_stays": somebody has come by it.
  core::Result<Platform> Put(Platform platform);
  /// As Add.
  core::Status CheckRoom();
  core::Result<std::vector<Platform>> List();
  /// "no_platform"
  core::Result<Platform> Get(std::int64_t id);
  /// @param client_id  may be empty where the issuer has one client only
  core::Result<Platform> Find(const std::string& issuer, const std::string& client_id);
  /// Its people keep their accounts; what waits for it is dropped.
  core::Status Remove(std::int64_t id);

  /// A grade that was sent, or waits.
  struct Sent {
    std::int64_t account = 0;
    std::int64_t assignment = 0;
    WallTime at{};
    std::string state;  ///< "waiting", "delivered", "given_up"
    std::int64_t attempts = 0;
    std::string error;
  };
  /// The newest first.
  core::Result<std::vector<Sent>> SentTo(std::int64_t id, int limit);

 private:
  Database& database_;
};

}  // namespace faultlab::server::lti

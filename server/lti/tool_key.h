#pragma once

#include <boost/json/object.hpp>
#include <string>
#include <utility>

#include "core/types/result.h"
#include "server/oidc/signing_key.h"
#include "server/storage/database.h"
#include "server/wall_time.h"

namespace faultlab::server::lti {

/// The key with which this lab signs what it says to platforms: made once, kept in the database,
/// the same for all its servers. Immutable, thread-safe.
class ToolKey {
 public:
  /// Makes it when there is none yet.
  static core::Result<ToolKey> Open(Database& database, WallTime now);

  /// The public half, as a JWK set.
  std::string KeySet() const;
  /// A JSON Web Token of these claims.
  std::string Sign(const boost::json::object& claims) const { return key_.Sign(claims, kid_); }

 private:
  ToolKey(std::string kid, oidc::SigningKey key) : kid_(std::move(kid)), key_(std::move(key)) {}

  std::string kid_;
  oidc::SigningKey key_;
};

}  // namespace faultlab::server::lti

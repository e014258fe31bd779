#pragma once

#include <boost/json/object.hpp>
#include <memory>
#include <string>

#include "core/types/result.h"
#include "server/storage/database.h"
#include "server/wall_time.h"

struct evp_pkey_st;

namespace faultlab::server::lti {

/// The key with which this lab signs what it says to platforms (RSA 2048): made once, kept in the
/// database, the same for all its servers. Immutable, thread-safe.
class ToolKey {
 public:
  /// Makes it when there is none yet.
  static core::Result<ToolKey> Open(Database& database, WallTime now);

  /// The public half, as a JWK set.
  std::string KeySet() const;
  /// A JSON Web Token of these claims, RS256.
  std::string Sign(const boost::json::object& claims) const;

 private:
  ToolKey(std::string kid, std::shared_ptr<evp_pkey_st> key)
      : kid_(std::move(kid)), key_(std::move(key)) {}

  std::string kid_;
  std::shared_ptr<evp_pkey_st> key_;
};

}  // namespace faultlab::server::lti

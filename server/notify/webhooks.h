#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/types/result.h"
#include "server/notify/message.h"
#include "server/storage/database.h"

namespace faultlab::server::notify {

/// A program that is told by POST.
struct Webhook {
  std::int64_t id = 0;
  std::int64_t account = 0;  ///< who is told of their own things; 0: the lab's, of everybody's
  std::string url;
  std::string secret;
  std::set<Kind> kinds;
  WallTime created{};
  std::optional<WallTime> delivered{};  ///< the newest message that it took
  std::optional<WallTime> failed{};     ///< the newest attempt that failed, and
  std::string error;                    ///< why
  std::int64_t waiting = 0;             ///< messages that it has not taken yet
};

/// The webhooks of this database. Thread-safe, stateless.
class Webhooks {
 public:
  static constexpr int kMax = 20;  ///< of the lab
  static constexpr int kOfPersonMax = 5;

  explicit Webhooks(Database& database) : database_(database) {}

  /// With a new secret. kConflict when there are too many.
  /// @param account  0: the lab's
  core::Result<Webhook> Add(std::int64_t account,
                            const std::string& url,
                            const std::set<Kind>& kinds,
                            WallTime now);
  /// Those of a person, and with `labs` those of the lab; oldest first.
  core::Result<std::vector<Webhook>> List(std::int64_t account, bool labs);
  /// kNotFound, also when its account is disabled.
  core::Result<Webhook> Get(std::int64_t id);
  /// With the messages that wait for it. kNotFound.
  core::Status Remove(std::int64_t id);
  /// What became of an attempt; an empty error: it was taken.
  core::Status Note(std::int64_t id, const std::string& error, WallTime now);

 private:
  Database& database_;
};

/// Those of the lab and of people who may sign in, without what waits for them. Throws what the
/// database throws.
std::vector<Webhook> LoadWebhooks(Transaction& tx);

}  // namespace faultlab::server::notify

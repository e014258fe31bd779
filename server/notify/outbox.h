#pragma once

#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "core/types/result.h"
#include "server/notify/message.h"
#include "server/storage/claimant.h"

namespace faultlab::server::notify {

/// The messages that are to be sent. A message is written in the transaction that reads its cause
/// (news.h), and waits until a receiver has taken it; so none is lost. A server that is killed
/// between sending and Delivered sends it again: at least once, with the same Message::delivery.
///
/// A claim is of one member and one of its memberships, as that of a job: it holds while the member
/// is in lab_member with this boot id, so that no time-out decides it. Thread-safe, stateless.
class Outbox {
 public:
  static constexpr auto kAgeMax = std::chrono::hours(24);  ///< then it is given up
  static constexpr auto kPatientAge =
      std::chrono::hours(24 * 30);          ///< of other channels than hooks
  static constexpr int kWaitingMax = 2000;  ///< in a channel; the oldest are given up
  static constexpr int kEndedKept = 5000;   ///< of hooks
  static constexpr auto kEndedAge = std::chrono::hours(24 * 7);

  explicit Outbox(Database& database) : database_(database) {}

  /// The message that is due for the longest time, now claimed; nullopt: none.
  /// @param not_these  channels that are busy or at rest
  /// @param of_people  also what is for the webhooks of people
  core::Result<std::optional<Message>> Claim(const Claimant& who,
                                             const std::set<std::string>& not_these,
                                             bool of_people,
                                             WallTime now);
  // These end a claim. kStale: it is over already.
  core::Status Delivered(const Message& claimed, WallTime now);
  core::Status Retry(const Message& claimed, const std::string& error, WallTime at);
  core::Status GiveUp(const Message& claimed, const std::string& error, WallTime now);

  /// Gives up what is too old and deletes ended rows beyond the bounds.
  core::Status Tidy(WallTime now);

 private:
  core::Status End(const Message& claimed, Parameters columns);

  Database& database_;
};

/// Part of the caller's transaction. Throws what the database throws.
namespace outbox {

void Add(Transaction& tx,
         const std::string& channel,
         std::int64_t account,
         std::string_view kind,
         const std::string& about,
         WallTime now);
/// Gives up the oldest of a channel beyond Outbox::kWaitingMax.
void KeepBound(Transaction& tx, const std::string& channel, WallTime now);

}  // namespace outbox
}  // namespace faultlab::server::notify

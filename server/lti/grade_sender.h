#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "server/clock.h"
#include "server/course/assignments.h"
#include "server/course/trial_keeper.h"
#include "server/lti/launch_flow.h"
#include "server/lti/platforms.h"
#include "server/lti/seats.h"
#include "server/lti/tool_key.h"
#include "server/notify/channel.h"

namespace faultlab::server::lti {

/// Sends grades to the gradebooks of platforms (LTI Assignment and Grade Services 2.0): the points
/// that a student has when they are sent, of 100. Blocks: never on a network thread. Thread-safe.
///
/// A platform that is away for days gets them when it is back (Outbox::kPatientAge).
class GradeSender : public notify::Channel {
 public:
  /// All parts must outlive it.
  /// @param keep  grades what is due: the platform is somebody who looks, too
  GradeSender(Database& database,
              const ToolKey& key,
              const Reach& reach,
              course::TrialKeeper keep,
              const Clock& clock);

  std::string_view prefix() const override { return "lti:"; }
  core::Result<bool> Gather(WallTime now) override;
  notify::Attempt Send(const notify::Message& message) override;

  /// A token for grades is given; or why not.
  core::Status CheckToken(const Platform& platform);

 private:
  struct Token {
    std::string text;
    MonotonicTime until{};
  };
  core::Result<std::string> TokenOf(const Platform& platform);
  void Forget(std::int64_t platform);

  course::TrialKeeper keep_;  ///< of the one thread that gathers
  Platforms platforms_;
  Seats seats_;
  course::Assignments assignments_;
  course::Trials trials_;
  const ToolKey& key_;
  const WebClient client_;
  const Clock& clock_;
  std::mutex mutex_;
  std::map<std::int64_t, Token> tokens_;
};

}  // namespace faultlab::server::lti

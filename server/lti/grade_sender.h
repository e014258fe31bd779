#pragma once

#include "server/clock.h"
#include "server/course/assignments.h"
#include "server/course/trial_keeper.h"
#include "server/lti/platform_client.h"
#include "server/lti/platforms.h"
#include "server/lti/seats.h"
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
              PlatformClient& client,
              course::TrialKeeper keep,
              const Clock& clock);

  std::string_view prefix() const override { return "lti:"; }
  core::Result<bool> Gather(WallTime now) override;
  notify::Attempt Send(const notify::Message& message) override;

 private:
  course::TrialKeeper keep_;  ///< of the one thread that gathers
  Platforms platforms_;
  Seats seats_;
  course::Assignments assignments_;
  course::Trials trials_;
  PlatformClient& client_;
  const Clock& clock_;
};

}  // namespace faultlab::server::lti

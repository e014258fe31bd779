#pragma once

#include <gmock/gmock.h>

#include <algorithm>
#include <string>
#include <vector>

#include "server/lab/lease.h"
#include "server/lab/scheduler.h"

namespace faultlab::server::lab {

using std::chrono::hours;
using std::chrono::minutes;
using std::chrono::seconds;

inline constexpr WallTime kNoon{Milliseconds{1'770'033'600'000}};
inline constexpr const char* kServer = "server";
inline constexpr UserId kAnn{1};
inline constexpr UserId kBob{2};
inline constexpr UserId kCem{3};
inline constexpr UserId kTeacher{9};

/// A scheduler at noon; the test decides when its checks between users pass.
class LabFixture : public testing::Test {
 protected:
  void AddReadyRigs(int count, const std::string& rig_class = "bench", bool elastic = false) {
    for (int i = 0; i < count; ++i) {
      const RigId id = rig_class + "-" + std::to_string(i + 1);
      ASSERT_TRUE(lab_.AddRig(id, rig_class, elastic).ok());
      ASSERT_TRUE(lab_.Claim(id, kServer, now_).ok());
    }
    PassChecks();
  }
  void PassChecks() {
    const LabState state = lab_.state();
    for (const auto& [id, rig] : state.rigs) {
      if (rig.status != RigStatus::kCleaning) continue;
      ASSERT_TRUE(lab_.CleaningDone(id, rig.epoch, true, "", now_).ok());
    }
  }
  void Pass(Milliseconds time) {
    now_ += time;
    lab_.Tick(now_);
    EXPECT_EQ(FindBrokenInvariant(lab_.state()), "");
  }
  Ticket Ask(UserId user, Milliseconds min = minutes(10), Milliseconds want = minutes(30)) {
    TicketRequest request;
    request.user = user;
    request.rig_class = "bench";
    request.min = min;
    request.want = want;
    const auto answer = lab_.RequestTicket(request, now_);
    EXPECT_TRUE(answer.ok());
    return std::get<Ticket>(answer.value());
  }
  static TicketRequest JobOf(UserId user, const std::string& job = "job-1") {
    TicketRequest request;
    request.user = user;
    request.rig_class = "bench";
    request.kind = TicketKind::kJob;
    request.job = job;
    request.min = request.want = minutes(1);
    return request;
  }
  Session Start(UserId user, Milliseconds want = minutes(30)) {
    const Ticket ticket = Ask(user, minutes(10), want);
    const auto session = lab_.AcceptTicket(ticket.id, user, now_);
    EXPECT_TRUE(session.ok()) << session.error().message;
    return session.value();
  }
  Booking Book(UserId user, Milliseconds in, Milliseconds length) {
    const auto booking = lab_.Book(user, "bench", {now_ + in, now_ + in + length}, now_);
    EXPECT_TRUE(booking.ok()) << booking.error().message;
    return booking.value();
  }
  RigStatus Status(const RigId& rig) const { return lab_.state().rigs.at(rig).status; }
  const Session* Live(SessionId id) const {
    const auto found = lab_.state().sessions.find(id);
    if (found == lab_.state().sessions.end()) return nullptr;
    return found->second.state == SessionState::kClosed ? nullptr : &found->second;
  }
  /// Topics of the messages to a user since the last call.
  std::vector<std::string> Told(UserId user) {
    std::vector<std::string> topics;
    for (const Notice& notice : lab_.TakeNotices()) {
      if (notice.user == user) topics.push_back(notice.topic);
    }
    return topics;
  }
  /// Whether the rig's fence, raised according to this state, accepts a command of this epoch.
  bool Admits(const RigId& rig, std::uint64_t epoch) const {
    Fence fence;
    fence.Raise(lab_.state().rigs.at(rig).epoch);
    return fence.Admits(epoch);
  }

  Scheduler lab_;
  WallTime now_ = kNoon;
};

}  // namespace faultlab::server::lab

#include "server/lab/opening.h"

#include "server/lab/obstacles.h"
#include "tests/server/lab/lab_fixture.h"

namespace faultlab::server::lab {
namespace {

using testing::ElementsAre;

constexpr std::int64_t kDrives = 3;  // a course

class Opening : public LabFixture {
 protected:
  core::Result<Window> Add(std::int64_t course,
                           std::vector<std::pair<Milliseconds, Milliseconds>> times) {
    Window window;
    window.rig_class = "bench";
    window.course = course;
    window.title = course == 0 ? "open" : "course " + std::to_string(course);
    for (const auto& [from, to] : times) window.times.push_back({now_ + from, now_ + to});
    return lab_.AddWindow(window, now_);
  }
  std::string Refusal(UserId user,
                      Milliseconds in,
                      Milliseconds length,
                      const Courses& courses = {}) const {
    const auto checked =
        lab_.CheckBooking(user, "bench", {now_ + in, now_ + in + length}, now_, courses);
    return checked.ok() ? "" : checked.error().reason;
  }
  Ticket AskIn(UserId user, const Courses& courses, Milliseconds min, Milliseconds want) {
    TicketRequest request;
    request.user = user;
    request.rig_class = "bench";
    request.min = min;
    request.want = want;
    request.courses = courses;
    const auto answer = lab_.RequestTicket(request, now_);
    EXPECT_TRUE(answer.ok());
    return std::get<Ticket>(answer.value());
  }
};

TEST_F(Opening, AClassWithoutHoursIsAlwaysOpenAndWithSomeInThemAlone) {
  AddReadyRigs(2);
  EXPECT_EQ(Refusal(kAnn, hours(20), hours(1)), "");
  // Two that abut are one; Monday and Tuesday, say.
  ASSERT_TRUE(Add(0, {{hours(1), hours(3)}, {hours(25), hours(27)}}).ok());
  ASSERT_TRUE(Add(0, {{hours(3), hours(5)}}).ok());
  EXPECT_EQ(Refusal(kAnn, hours(1), hours(4)), "");
  EXPECT_EQ(Refusal(kAnn, hours(4), minutes(61)), "class_closed");
  EXPECT_EQ(Refusal(kAnn, minutes(59), minutes(30)), "class_closed");
  EXPECT_EQ(Refusal(kAnn, hours(25), hours(2)), "");
  EXPECT_EQ(Refusal(kAnn, hours(30), hours(1)), "class_closed");
}

TEST_F(Opening, TheHoursOfACourseAreItsPeoplesAlsoOutsideTheOpeningHours) {
  AddReadyRigs(1);
  ASSERT_TRUE(Add(0, {{hours(1), hours(5)}}).ok());
  ASSERT_TRUE(Add(kDrives, {{hours(2), hours(3)}, {hours(10), hours(11)}}).ok());
  EXPECT_EQ(Refusal(kAnn, hours(2), hours(1), {1, kDrives}), "");
  EXPECT_EQ(Refusal(kAnn, hours(1), hours(4), {kDrives}), "");
  EXPECT_EQ(Refusal(kAnn, hours(10), hours(1), {kDrives}), "");
  EXPECT_EQ(Refusal(kBob, hours(2), hours(1), {1, 2}), "hours_of_course");
  EXPECT_EQ(Refusal(kBob, minutes(90), minutes(31)), "hours_of_course");
  EXPECT_EQ(Refusal(kBob, hours(3), hours(2)), "");
  EXPECT_EQ(Refusal(kBob, hours(10), hours(1)), "hours_of_course");
}

TEST_F(Opening, TwoCoursesCannotHaveTheSameHoursAndSimulatorsHaveNone) {
  AddReadyRigs(1);
  AddReadyRigs(1, "sim", true);
  ASSERT_TRUE(Add(kDrives, {{hours(2), hours(4)}}).ok());
  const auto rival = Add(4, {{hours(1), hours(2)}, {hours(3), hours(5)}});
  ASSERT_FALSE(rival.ok());
  EXPECT_EQ(rival.error().reason, "window_overlaps");
  EXPECT_TRUE(Add(4, {{hours(1), hours(2)}, {hours(4), hours(5)}}).ok());
  EXPECT_TRUE(Add(kDrives, {{hours(3), hours(6)}}).error().reason == "window_overlaps");
  Window simulators;
  simulators.rig_class = "sim";
  simulators.times = {{now_, now_ + hours(1)}};
  EXPECT_EQ(lab_.AddWindow(simulators, now_).error().reason, "class_always_open");
  simulators.rig_class = "none";
  EXPECT_EQ(lab_.AddWindow(simulators, now_).error().reason, "no_rig_class");
}

TEST_F(Opening, NobodyIsServedInAShutTimeAndTheEstimateKnowsIt) {
  AddReadyRigs(1);
  ASSERT_TRUE(Add(0, {{hours(1), hours(5)}}).ok());
  ASSERT_TRUE(Add(kDrives, {{hours(1), hours(2)}}).ok());
  const Ticket stranger = AskIn(kAnn, {}, minutes(10), minutes(30));
  const Ticket member = AskIn(kBob, {kDrives}, minutes(10), minutes(90));
  EXPECT_EQ(stranger.state, TicketState::kWaiting);
  EXPECT_GE(*stranger.expected, now_ + hours(2));
  EXPECT_EQ(*member.expected, now_ + hours(1));
  Pass(hours(1));
  EXPECT_EQ(lab_.state().tickets.at(stranger.id).state, TicketState::kWaiting);
  const auto session = lab_.AcceptTicket(member.id, kBob, now_);
  ASSERT_TRUE(session.ok());
  EXPECT_EQ(session.value().courses, Courses{kDrives});
}

TEST_F(Opening, WhoNeverFitsKeepsNobodyFromATime) {
  AddReadyRigs(1);
  ASSERT_TRUE(Add(0, {{hours(1), hours(2)}, {hours(25), hours(26)}}).ok());
  const Ticket never = AskIn(kAnn, {}, minutes(90), minutes(90));
  const Ticket soon = AskIn(kBob, {}, minutes(10), minutes(30));
  EXPECT_EQ(never.expected, std::nullopt);
  EXPECT_EQ(soon.expected, now_ + hours(1));
}

TEST_F(Opening, ASessionAndItsCheckEndBeforeAShutTime) {
  AddReadyRigs(1);
  ASSERT_TRUE(Add(0, {{Milliseconds{0}, minutes(40)}}).ok());
  const Session session = Start(kAnn, minutes(60));
  EXPECT_EQ(session.hard_end, now_ + minutes(40) - lab_.policy().cleaning);
  const WallTime end = session.hard_end;
  (void)Told(kAnn);
  Pass(end - now_ - minutes(2));
  ASSERT_NE(Live(session.id), nullptr);
  EXPECT_EQ(Live(session.id)->hard_end, end) << "it is not extended into the night";
  const std::vector<Notice> notices = lab_.TakeNotices();
  ASSERT_FALSE(notices.empty());
  EXPECT_EQ(notices.back().topic, "warning");
  EXPECT_EQ(notices.back().reason, "hours");
  Pass(minutes(3));
  EXPECT_EQ(Live(session.id), nullptr);
}

TEST_F(Opening, AMembersSessionGoesOnUntilTheirHoursEnd) {
  AddReadyRigs(1);
  ASSERT_TRUE(Add(kDrives, {{Milliseconds{0}, hours(1)}}).ok());
  const Ticket ticket = AskIn(kAnn, {kDrives}, minutes(10), minutes(15));
  const auto session = lab_.AcceptTicket(ticket.id, kAnn, now_);
  ASSERT_TRUE(session.ok());
  Pass(minutes(11));
  EXPECT_GT(Live(session.value().id)->hard_end, session.value().hard_end);
}

TEST_F(Opening, WhatWasPromisedBeforeStays) {
  AddReadyRigs(1);
  const Booking booking = Book(kAnn, hours(10), hours(1));
  ASSERT_TRUE(Add(0, {{hours(1), hours(5)}}).ok());
  Pass(hours(10));
  const auto session = lab_.ClaimBooking(booking.id, kAnn, now_);
  ASSERT_TRUE(session.ok());
  EXPECT_EQ(session.value().hard_end, booking.during.end - lab_.policy().cleaning);
}

TEST_F(Opening, TellsWhoWaitsUntilWhenTheClassIsShut) {
  AddReadyRigs(1);
  ASSERT_TRUE(Add(0, {{hours(1), hours(5)}, {hours(25), hours(30)}}).ok());
  Ticket ticket;
  ticket.rig_class = "bench";
  ticket.min = minutes(10);
  const auto first = [&] {
    const auto all = ObstaclesOf(lab_.state(), ticket, now_);
    return all.empty() || all.front().kind != ObstacleKind::kHours ? Obstacle{} : all.front();
  };
  EXPECT_EQ(first(), (Obstacle{"", ObstacleKind::kHours, {{}, kNoon + hours(1)}}));
  Pass(hours(2));
  EXPECT_EQ(first(), Obstacle{});
  Pass(minutes(175));
  EXPECT_EQ(first(), (Obstacle{"", ObstacleKind::kHours, {kNoon + hours(5), kNoon + hours(25)}}));
}

TEST_F(Opening, HoursThatAreGoneShutNothing) {
  AddReadyRigs(1);
  const auto window = Add(0, {{hours(1), hours(2)}});
  ASSERT_TRUE(window.ok());
  const Changes added = lab_.TakeChanges();
  EXPECT_THAT(added.windows, ElementsAre(window.value()));
  ASSERT_TRUE(lab_.RemoveWindow(window.value().id, now_).ok());
  EXPECT_THAT(lab_.TakeChanges().ended_windows, ElementsAre(window.value().id));
  EXPECT_EQ(Refusal(kAnn, hours(10), hours(1)), "");
  EXPECT_EQ(lab_.RemoveWindow(window.value().id, now_).error().reason, "no_window");
}

TEST_F(Opening, ASeriesIsBookedAsAWholeOrNotAtAll) {
  AddReadyRigs(1);
  Book(kBob, hours(48), hours(1));
  const auto times = [&](int count) {
    std::vector<Interval> out;
    for (int i = 1; i <= count; ++i)
      out.push_back({now_ + hours(24 * i), now_ + hours(24 * i + 1)});
    return out;
  };
  const auto refused = lab_.BookAll(kAnn, "bench", times(3), now_, {});
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().reason, "series_refused");
  EXPECT_EQ(refused.error().parameters.front().value, UtcText(now_ + hours(48)));
  EXPECT_EQ(lab_.state().bookings.size(), 1u);
  EXPECT_EQ(lab_.BookAll(kAnn, "bench", times(1), now_, {}).value().size(), 1u);
  std::vector<Interval> later = {{now_ + hours(72), now_ + hours(73)},
                                 {now_ + hours(96), now_ + hours(97)}};
  const auto booked = lab_.BookAll(kAnn, "bench", later, now_, {});
  ASSERT_TRUE(booked.ok());
  EXPECT_EQ(booked.value().size(), 2u);
  EXPECT_EQ(lab_.state().bookings.size(), 4u);
  EXPECT_EQ(lab_.TakeChanges().bookings.size(), 4u);
  EXPECT_EQ(lab_.BookAll(kAnn, "bench", times(9), now_, {}).error().reason, "series_refused");
}

}  // namespace
}  // namespace faultlab::server::lab

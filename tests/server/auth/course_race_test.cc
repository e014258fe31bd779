// Two servers on one PostgreSQL make courses at the same moment.
#include <gmock/gmock.h>

#include "server/auth/accounts.h"
#include "tests/support/insert_race.h"

namespace faultlab::server {
namespace {

constexpr WallTime kNow{std::chrono::milliseconds{1'770'000'000'000}};

TEST(CourseRace, WhoeverMakesACourseTeachesThatOneAndNoOther) {
  tests::TestDatabase database(Engine::kPostgresql);
  const auto other = database.OpenAnother();
  Accounts here(*database, GuestAccess::kNever);
  Accounts there(*other, GuestAccess::kNever);
  const std::int64_t ann = here.Create("ann", "Ann", Role::kInstructor, kNow).value().id;
  const std::int64_t bob = here.Create("bob", "Bob", Role::kInstructor, kNow).value().id;
  tests::InsertRace race(database, "course");
  std::int64_t of_ann = 0;
  std::int64_t of_bob = 0;
  race.Run([&] { of_ann = here.CreateCourse("first", ann, kNow).value().id; },
           [&] { of_bob = there.CreateCourse("second", bob, kNow).value().id; });
  EXPECT_NE(of_ann, of_bob);
  EXPECT_TRUE(here.Teaches(ann, of_ann).value());
  EXPECT_TRUE(here.Teaches(bob, of_bob).value());
  EXPECT_FALSE(here.Teaches(ann, of_bob).value()) << "a teacher has got into another's course";
}

}  // namespace
}  // namespace faultlab::server

#include "server/lab/fault_sets.h"

#include <gmock/gmock.h>

#include "tests/support/engines.h"
#include "tests/support/insert_race.h"
#include "tests/support/test_database.h"

namespace faultlab::server::lab {
namespace {

FaultSet Named(const std::string& name, std::int64_t author) {
  FaultSet set;
  set.name = name;
  set.author = author;
  set.faults_json = "[]";
  return set;
}

TEST(FaultSetRace, TheAnswerNamesTheSetThatWasMade) {
  tests::TestDatabase database(Engine::kPostgresql);
  const auto other = database.OpenAnother();
  FaultSets here(*database);
  FaultSets there(*other);
  tests::InsertRace race(database, "fault_set");
  std::int64_t first = 0;
  std::int64_t second = 0;
  race.Run([&] { first = here.Create(Named("first", 1)).value().id; },
           [&] { second = there.Create(Named("second", 2)).value().id; });
  EXPECT_EQ(here.Get(first).value().name, "first");
  EXPECT_EQ(here.Get(second).value().name, "second");
}

}  // namespace
}  // namespace faultlab::server::lab

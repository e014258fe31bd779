#include "server/lab/lab_id.h"

#include <gmock/gmock.h>

#include <future>
#include <set>
#include <vector>

#include "tests/support/engines.h"
#include "tests/support/test_database.h"

namespace faultlab::server::lab {
namespace {

class LabIdTest : public testing::TestWithParam<Engine> {
 protected:
  tests::TestDatabase database_{GetParam()};
};

TEST_P(LabIdTest, IsMadeOnceForADatabaseAndIsNoOthers) {
  const std::string id = LabId(*database_).value();
  EXPECT_GT(id.size(), 10u);
  EXPECT_EQ(id.find('/'), std::string::npos) << "it stands before the slash of a holder's name";
  database_.Reopen();
  EXPECT_EQ(LabId(*database_).value(), id);
  tests::TestDatabase other(GetParam());
  EXPECT_NE(LabId(*other).value(), id);
}

TEST_P(LabIdTest, IsTheSameForServersThatStartTogether) {
  constexpr int kServers = 8;
  std::vector<std::unique_ptr<Database>> doors;
  for (int i = 0; i < kServers; ++i) doors.push_back(database_.OpenAnother());
  std::vector<std::future<std::string>> asked;
  for (const auto& door : doors) {
    asked.push_back(std::async(std::launch::async, [&door] { return LabId(*door).value(); }));
  }
  std::set<std::string> ids;
  for (auto& each : asked) ids.insert(each.get());
  EXPECT_EQ(ids.size(), 1u);
}

INSTANTIATE_TEST_SUITE_P(Engines, LabIdTest, tests::kBothEngines, tests::EngineName);

}  // namespace
}  // namespace faultlab::server::lab

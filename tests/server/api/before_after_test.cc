#include "server/api/run/before_after.h"
#include "tests/support/paths.h"

#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <fstream>
#include <iterator>

namespace faultlab::server {
namespace {

namespace json = boost::json;

std::vector<double> NumbersOf(const json::value& list) {
  std::vector<double> out;
  for (const json::value& each : list.as_array()) out.push_back(each.to_number<double>());
  return out;
}

/// The page is tested with the same list.
TEST(StretchesAround, FollowsTheRuleThatThePageFollows) {
  std::ifstream file(tests::InSource("tests/server/api/before_after_cases.json"));
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const json::array cases = json::parse(text).as_array();
  ASSERT_GE(cases.size(), 7U);
  for (const json::value& entry : cases) {
    const json::object& one = entry.as_object();
    core::EstimatorShape shape = core::kEstimatorShapes[0];
    shape.window_samples = one.at("window").to_number<int>();
    shape.integral_samples = one.at("integral").to_number<int>();
    const json::value& at = one.at("at_s");
    const Stretches found =
        StretchesAround(at.is_null() ? std::nullopt : std::optional(at.to_number<double>()),
                        NumbersOf(one.at("changes")),
                        one.at("end_s").to_number<double>(),
                        shape,
                        one.at("period_s").to_number<double>());
    const std::vector<double> before = NumbersOf(one.at("before"));
    const std::vector<double> after = NumbersOf(one.at("after"));
    constexpr double kTolerance = 1e-9;
    EXPECT_NEAR(found.before.from_s, before[0], kTolerance) << one.at("name");
    EXPECT_NEAR(found.before.to_s, before[1], kTolerance) << one.at("name");
    EXPECT_NEAR(found.after.from_s, after[0], kTolerance) << one.at("name");
    EXPECT_NEAR(found.after.to_s, after[1], kTolerance) << one.at("name");
  }
}

}  // namespace
}  // namespace faultlab::server

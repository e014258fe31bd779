// A run under speed control: planned, played, read.
#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <map>
#include <string>

#include "tests/server/api/api_world.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

class ControlApiTest : public ApiTest {
 protected:
  std::string Played(const std::string& more) {
    const std::string body = R"({"rig":"sim-1","seed":7,"duration_s":16,)" + more + "}";
    const json::object run = Ok(Call(kNobody, "POST runs", body), 201);
    std::string id(run.at("id").as_string());
    application_->runs().Wait(id);
    return id;
  }
  json::object ControlOf(const std::string& id, const std::string& query = "?without=include") {
    return Ok(Call(kNobody, "GET runs/" + id + "/control" + query));
  }
  json::object Refused(const std::string& control, const std::string& more = "") {
    const std::string body = R"({"duration_s":16,"control":)" + control + more + "}";
    return Ok(Call(kNobody, "POST runs", body), 400);
  }
};

TEST_F(ControlApiTest, ARunKeepsItsSpeedAlthoughAPartFails) {
  const std::string id =
      Played(R"("control":{},"faults":[{"component":"R1","value":56,"at_s":9}])");
  const json::object run = Ok(Call(kNobody, "GET runs/" + id));
  EXPECT_EQ(run.at("state"), "finished") << run;
  const json::object& planned = run.at("plan").as_object().at("control").as_object();
  EXPECT_EQ(planned.at("controller"), "compensated");
  EXPECT_EQ(planned.at("from_s").to_number<double>(), 5.5);

  const json::object control = ControlOf(id);
  EXPECT_NEAR(control.at("began_s").to_number<double>(), 5.5, 0.02) << control;
  const json::array& made_up = control.at("compensations").as_array();
  ASSERT_EQ(made_up.size(), 1U) << control;
  EXPECT_EQ(made_up[0].at("component"), "R1");
  EXPECT_NEAR(made_up[0].at("value").to_number<double>(), 56.0, 0.5);
  EXPECT_LT(made_up[0].at("t_s").to_number<double>(), 9.1) << "four samples after the alarm";
  EXPECT_TRUE(made_up[0].at("until_s").is_null());
  EXPECT_EQ(control.at("accommodated"), true);
  EXPECT_NEAR(control.at("dither_rad_s").to_number<double>(), 4.0, 1.0);
  // A speed that is kept tells the gain, and little of the motor.
  std::map<std::string, double> visible;
  for (const json::value& each : control.at("visible").as_array()) {
    const json::value& percent = each.at("from_percent");
    visible[Text(each, "component")] = percent.is_null() ? 1e9 : percent.to_number<double>();
  }
  ASSERT_TRUE(visible.contains("k") && visible.contains("Ra")) << control;
  EXPECT_LT(visible["k"], 5.0);
  EXPECT_GT(visible["Ra"], 5.0 * visible["k"]);

  const json::object& without = control.at("without").as_object();
  const double with_iae = control.at("quality").at("iae_rad").to_number<double>();
  const double without_iae = without.at("quality").at("iae_rad").to_number<double>();
  EXPECT_LT(with_iae, 0.8 * without_iae);
  EXPECT_NEAR(control.at("quality").at("from_s").to_number<double>(), 9.0, 0.02);
  EXPECT_EQ(
      without.at("n_rpm").as_array().size(),
      1600U - static_cast<std::size_t>(control.at("began_s").to_number<double>() * 100.0 + 0.5));
  const json::array& corners = control.at("reference").at("t_s").as_array();
  EXPECT_EQ(corners.front().to_number<double>(), 5.5);
  EXPECT_EQ(corners.back().to_number<double>(), 16.0);
  EXPECT_TRUE(ControlOf(id, "").at("without").is_null());

  const json::object figure = Ok(Call(kNobody, "GET runs/" + id + "/figures/signals"));
  bool drawn = false;
  for (const json::value& panel : figure.at("panels").as_array()) {
    for (const json::value& series : panel.at("series").as_array()) {
      drawn = drawn || series.at("name") == "reference";
    }
  }
  EXPECT_TRUE(drawn) << "the speed that it was to have";
}

TEST_F(ControlApiTest, WhatCannotBeMadeUpForIsSaidWithTheSpeedThatCanBeReached) {
  const std::string id =
      Played(R"("control":{},"faults":[{"component":"R12","value":2000,"at_s":9}])");
  const json::object control = ControlOf(id);
  EXPECT_EQ(control.at("accommodated"), false);
  EXPECT_NEAR(control.at("reachable_rad_s").to_number<double>(), 149.0, 6.0);
}

/// "Without" is the run itself, as long as nothing has been compensated.
TEST_F(ControlApiTest, WithoutADiagnosisItIsTheSameRun) {
  const std::string id = Played(
      R"("control":{"controller":"nominal"},"faults":[{"component":"R9","value":33000,"at_s":9}])");
  const json::object control = ControlOf(id);
  EXPECT_TRUE(control.at("compensations").as_array().empty());
  const double played = control.at("quality").at("iae_rad").to_number<double>();
  const double again = control.at("without").at("quality").at("iae_rad").to_number<double>();
  EXPECT_NEAR(played, again, 0.02 * played);
}

TEST_F(ControlApiTest, TheSamePlanAndSeedGiveTheSameRun) {
  const std::string plan =
      R"("control":{"reference":{"shape":"prbs","hold_s":0.5}},"faults":[{"component":"Ra","value":14,"at_s":9}])";
  json::object one = ControlOf(Played(plan));
  json::object two = ControlOf(Played(plan));
  EXPECT_EQ(json::serialize(one), json::serialize(two));
}

TEST_F(ControlApiTest, RefusesWhatCannotBeKept) {
  EXPECT_EQ(Refused(R"({"reference":{"high_rad_s":2000}})").at("reason"), "speed_out_of_reach");
  EXPECT_EQ(Refused(R"({"reference":{"hold_s":0.01}})").at("field"), "/control/reference/hold_s");
  EXPECT_EQ(Refused(R"({"reference":{"low_rad_s":0}})").at("field"),
            "/control/reference/low_rad_s");
  EXPECT_EQ(Refused(R"({"controller":"magic"})").at("field"), "/control/controller");
  EXPECT_EQ(Refused(R"({"gain":3})").at("field"), "/control/gain");
  const json::object brief =
      Ok(Call(kNobody, "POST runs", R"({"duration_s":5,"control":{}})"), 400);
  EXPECT_EQ(brief.at("reason"), "control_after_end") << brief;
  const std::string plain = R"({"rig":"sim-1","duration_s":2})";
  const json::object run = Ok(Call(kNobody, "POST runs", plain), 201);
  const std::string id = Id(run);
  application_->runs().Wait(id);
  const json::object none = Ok(Call(kNobody, "GET runs/" + id + "/control"), 404);
  EXPECT_EQ(none.at("reason"), "run_without_control");
}

}  // namespace
}  // namespace faultlab::server

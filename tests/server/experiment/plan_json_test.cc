#include "server/experiment/plan_json.h"

#include <gtest/gtest.h>

#include <boost/json.hpp>

#include "server/json/json_reader.h"
#include "tests/paper_bench.h"

namespace faultlab::server {
namespace {

core::Result<ExperimentPlan> Parsed(std::string_view text, std::uint64_t default_seed) {
  const auto object = ParseJsonObject(text);
  if (!object) return object.error();
  return ParsePlan(object.value(), paper::Bench(), default_seed);
}

hardware::RigDescription Simulator() {
  hardware::RigDescription rig;
  rig.bench = &paper::Bench();
  rig.id = "sim-1";
  rig.uc_v_max = 5.0;
  rig.any_value = true;
  rig.motor_faults = true;
  return rig;
}

/// The refused field, by the parser or by the rig's envelope; "" if nothing is refused.
std::string RefusedField(const std::string& text, const hardware::RigDescription& rig) {
  const auto body = Parsed(text, 1);
  if (!body.ok()) return body.error().field.empty() ? "body" : body.error().field;
  const auto plan = ResolvePlan(body.value(), rig);
  return plan.ok() ? "" : plan.error().field;
}

TEST(PlanJson, IsThePapersExperimentByDefault) {
  const auto body = Parsed("", 5);
  ASSERT_TRUE(body.ok());
  EXPECT_EQ(body.value().duration_s, 20.0);
  EXPECT_EQ(body.value().seed, 5u);
  const auto plan = ResolvePlan(body.value(), Simulator());
  ASSERT_TRUE(plan.ok());
  EXPECT_EQ(plan.value().uc_v.size(), 2000u);
  for (const double volts : plan.value().uc_v) ASSERT_TRUE(volts == 2.0 || volts == 3.0);
}

TEST(PlanJson, ReadsEveryKindOfFaultAndExcitation) {
  for (const char* excitation : {R"({"kind":"prbs","low_v":1,"high_v":4,"clock_s":0.02,"seed":3})",
                                 R"({"kind":"step","low_v":1,"high_v":2,"at_s":3})",
                                 R"({"kind":"multisine","offset_v":2,"amplitude_v":1,"lines":9})",
                                 R"({"kind":"chirp","from_hz":1,"to_hz":5})"}) {
    const std::string text =
        std::string(R"({"duration_s":10,"excitation":)") + excitation +
        R"(,"faults":[{"component":"J","value":1e-5,"at_s":2,"kind":"drift","until_s":8},)" +
        R"({"component":"R9","value":33000,"at_s":3,"kind":"intermittent","until_s":4}]})";
    const auto body = Parsed(text, 1);
    ASSERT_TRUE(body.ok()) << excitation << body.error().message;
    ASSERT_EQ(body.value().faults.size(), 2u);
    EXPECT_EQ(body.value().faults[0].kind, core::FaultKind::kDrift);
    EXPECT_EQ(body.value().faults[1].until_s, 4.0);
    EXPECT_TRUE(ResolvePlan(body.value(), Simulator()).ok()) << excitation;
    // The plan that is stored can be read back.
    const auto plan = PlanToJson(body.value(), Simulator());
    EXPECT_EQ(FaultsOfPlan(boost::json::serialize(plan), paper::Bench()).size(), 2u);
  }
}

TEST(PlanJson, TakesItsLengthFromAListOfSamples) {
  std::string list = "2";
  for (int i = 1; i < 150; ++i) list += ",2.5";
  const std::string samples = R"("excitation":{"kind":"samples","uc_v":[)" + list + "]}";
  const auto body = Parsed("{" + samples + "}", 1);
  ASSERT_TRUE(body.ok()) << body.error().message;
  EXPECT_DOUBLE_EQ(body.value().duration_s, 1.5);
  EXPECT_EQ(RefusedField("{" + samples + R"(,"duration_s":20})", Simulator()), "/duration_s");
}

TEST(PlanJson, NamesTheFieldThatIsWrong) {
  const struct {
    const char* text;
    const char* field;
  } cases[] = {
      {"nonsense", "body"},
      {"[]", "body"},
      {R"({"colour":"red"})", "/colour"},
      {R"({"duration_s":3600})", "/duration_s"},
      {R"({"duration_s":0})", "/duration_s"},
      {R"({"duration_s":"20"})", "/duration_s"},
      {R"({"period_s":0})", "/period_s"},
      {R"({"period_s":0.0005})", "/period_s"},
      {R"({"seed":-1})", "/seed"},
      {R"({"name":7})", "/name"},
      {R"({"name":"a\nb"})", "/name"},
      {R"({"rig":["sim-1"]})", "/rig"},
      {R"({"excitation":"prbs"})", "/excitation"},
      {R"({"excitation":{"kind":"noise"}})", "/excitation/kind"},
      {R"({"excitation":{"kind":"prbs","hight_v":3}})", "/excitation/hight_v"},
      {R"({"excitation":{"kind":"prbs","high_v":12}})", "/excitation/high_v"},
      {R"({"excitation":{"kind":"prbs","low_v":-1}})", "/excitation/low_v"},
      {R"({"excitation":{"kind":"multisine","amplitude_v":4}})", "/excitation/amplitude_v"},
      {R"({"excitation":{"kind":"samples"}})", "/excitation/uc_v"},
      {R"({"excitation":{"kind":"samples","uc_v":[1,"x"]}})", "/excitation/uc_v/1"},
      {R"({"excitation":{"kind":"samples","uc_v":[1,2]}})", "/excitation/uc_v"},
      {R"({"faults":{}})", "/faults"},
      {R"({"faults":["R1"]})", "/faults/0"},
      {R"({"faults":[{"component":"R2","value":1}]})", "/faults/0/component"},
      {R"({"faults":[{"component":"R1"}]})", "/faults/0/value"},
      {R"({"faults":[{"component":"R1","value":0}]})", "/faults/0/value"},
      {R"({"faults":[{"component":"R1","value":1e400}]})", "/faults/0/value"},
      {R"({"faults":[{"component":"R1","value":10,"at_s":20}]})", "/faults/0/at_s"},
      {R"({"faults":[{"component":"R1","value":10,"at_s":-1}]})", "/faults/0/at_s"},
      {R"({"faults":[{"component":"R1","value":10,"kind":"sudden"}]})", "/faults/0/kind"},
      {R"({"faults":[{"component":"R1","value":10,"kind":"drift"}]})", "/faults/0/until_s"},
      {R"({"faults":[{"component":"R1","value":10,"until_s":15}]})", "/faults/0/until_s"},
      {R"({"faults":[{"component":"R1","value":10},{"component":"J","value":1,"x":1}]})",
       "/faults/1/x"},
      {R"({"recording":"rec-1","faults":[]})", "/faults"},
      {R"({"recording":"rec-1","duration_s":20})", "/duration_s"},
  };
  for (const auto& wrong : cases) {
    EXPECT_EQ(RefusedField(wrong.text, Simulator()), wrong.field) << wrong.text;
  }
}

TEST(PlanJson, AsksARelayBoardOnlyForWhatItHas) {
  hardware::RigDescription bench;
  bench.bench = &paper::Bench();
  bench.uc_v_max = 5.0;
  bench.id = "bench-1";
  EXPECT_EQ(RefusedField(R"({"faults":[{"component":"R1","value":56}]})", bench), "");
  EXPECT_EQ(RefusedField(R"({"faults":[{"component":"R1","value":57}]})", bench),
            "/faults/0/value");
  EXPECT_EQ(RefusedField(R"({"faults":[{"component":"J","value":1e-5}]})", bench),
            "/faults/0/component");
}

}  // namespace
}  // namespace faultlab::server

// A recording is shown with the options and the diagnosis that are stored with it.
#include "server/experiment/recordings.h"
#include "core/diagnosis/diagnose_record.h"

#include <gtest/gtest.h>

#include <soci/soci.h>

#include <boost/json.hpp>
#include <chrono>
#include <string>

#include "server/diagnosis_json/diagnosis_json.h"
#include "server/diagnosis_json/options_json.h"
#include "tests/paper_rig.h"
#include "tests/server/run/run_fixture.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

class RecordingsTest : public tests::RunFixture {
 protected:
  /// R1 = 100 ohm in a run whose options state that relays connect it: identified as exactly 100.
  RunRecord RunOfARealBench() {
    RunRequest request = Paper();
    request.diagnosis.values = core::ValuePrior::kTable2;
    const RunRecord record = RunToEnd(std::move(request));
    EXPECT_EQ(record.verdict, "fault") << record.diagnosis_json;
    return record;
  }
  static double ValueFound(const std::string& diagnosis) {
    const auto parsed = ParseDiagnosis(diagnosis, paper::Bench());
    EXPECT_TRUE(parsed.ok()) << parsed.error().message;
    return parsed.value().verdict.candidates.front().value;
  }
  Figure Draw(const std::string& id, const std::string& name) {
    auto figure = recordings_.FigureOf(store_->Get(id).value(), name, "");
    EXPECT_TRUE(figure.ok()) << figure.error().message;
    return std::move(figure).value();
  }
  static const Mark* Find(const Figure& figure, MarkKind kind) {
    for (const Mark& mark : figure.marks) {
      if (mark.kind == kind) return &mark;
    }
    return nullptr;
  }

  Accounts accounts_{*database_, GuestAccess::kEverywhere, PasswordCost::kLeast};
  Benches benches_{*database_, {&paper::Bench()}};
  Recordings recordings_{
      *store_, *manager_, accounts_, benches_, clock_, {200'000, 16 << 20}, "server-a"};
};

TEST_F(RecordingsTest, OptionsComeBackFromTheirText) {
  core::DiagnosisOptions options = paper::Options();
  options.nominal.j_kg_m2 = 1.0 / 3.0 * 1e-6;
  const int r5 = options.bench->structure->Find("R5");
  options.nominal.Set(r5, 999.0 + 1.0 / 7.0);
  options.calibration = Learnt();
  options.healthy_from_s = 0.1 + 0.2;
  options.healthy_to_s = 4.25;
  options.channels = core::Channels::kUmOnly;
  options.values = core::ValuePrior::kTable2;
  options.motor_faults = false;
  options.period_s = 0.005;
  options.false_alarms_per_day = 0.3;
  options.um_rail_v = 9.99;
  options.model = core::ModelScope::kSimulator;
  options.calibration->model_covariance.assign(options.calibration->covariance.size(), 1e-4);
  core::ModelError& left = options.calibration->model_error;
  left.step_v = 0.4;
  left.walk = {0.02, -0.01, 0.0};
  left.growth[1][2] = 2.5;
  left.raised[2][4] = 3.0;
  const auto back = ParseOptions(OptionsText(options), paper::Bench());
  ASSERT_TRUE(back.ok()) << back.error().message;
  EXPECT_EQ(back.value().calibration->model_error, left);
  EXPECT_DOUBLE_EQ(back.value().nominal.j_kg_m2, options.nominal.j_kg_m2);
  EXPECT_DOUBLE_EQ(back.value().nominal.Get(r5), options.nominal.Get(r5));
  EXPECT_DOUBLE_EQ(back.value().healthy_from_s, options.healthy_from_s);
  EXPECT_EQ(back.value().healthy_to_s, options.healthy_to_s);
  EXPECT_EQ(back.value().channels, options.channels);
  EXPECT_EQ(back.value().values, options.values);
  EXPECT_EQ(back.value().motor_faults, options.motor_faults);
  EXPECT_EQ(back.value().period_s, options.period_s);
  EXPECT_EQ(back.value().false_alarms_per_day, options.false_alarms_per_day);
  EXPECT_EQ(back.value().um_rail_v, options.um_rail_v);
  ASSERT_TRUE(back.value().calibration);
  EXPECT_DOUBLE_EQ(back.value().calibration->delta_s, options.calibration->delta_s);
  EXPECT_EQ(back.value().model, core::ModelScope::kSimulator);
  options.model = core::ModelScope::kBuiltRig;
  EXPECT_EQ(ParseOptions(OptionsText(options), paper::Bench()).value().model,
            core::ModelScope::kBuiltRig);
  EXPECT_EQ(back.value().calibration->model_covariance, options.calibration->model_covariance);
}

TEST_F(RecordingsTest, OptionsFromBeforeMissingPhysicsWasKnownAreRead) {
  core::DiagnosisOptions options = paper::Options();
  options.calibration = Learnt();
  json::object old = json::parse(OptionsText(options)).as_object();
  old.erase("model_is_exact");
  old.erase("built_rig");
  old.at("calibration").as_object().erase("covariance_model");
  const auto back = ParseOptions(json::serialize(old), paper::Bench());
  ASSERT_TRUE(back.ok()) << back.error().message;
  EXPECT_EQ(back.value().model, core::ModelScope::kAsDescribed);
  EXPECT_TRUE(back.value().calibration->model_covariance.empty());
  EXPECT_FALSE(back.value().calibration->model_error.any());
}

TEST_F(RecordingsTest, OlderModelErrorTellsTheWalkOfRaAlone) {
  core::DiagnosisOptions options = paper::Options();
  options.calibration = Learnt();
  options.calibration->model_error.walk = {0.02, -0.01, 0.0};
  json::object old = json::parse(OptionsText(options)).as_object();
  json::object& left = old.at("calibration").as_object().at("model_error").as_object();
  left.erase("walk");
  left["ra_walk"] = 0.02;
  const auto back = ParseOptions(json::serialize(old), paper::Bench());
  ASSERT_TRUE(back.ok()) << back.error().message;
  EXPECT_EQ(back.value().calibration->model_error.walk, (std::array<double, 3>{0.02, 0.0, 0.0}));
}

TEST_F(RecordingsTest, ModelErrorsThatAreNoFactorsAreRefused) {
  core::DiagnosisOptions options = paper::Options();
  options.calibration = Learnt();
  options.calibration->model_error.walk = {0.02, 0.0, 0.0};
  const json::object good = json::parse(OptionsText(options)).as_object();
  for (const char* damage : {"[[1],[1],[1]]",
                             "[]",
                             "7",
                             "[[0,1,1,1,1,1,1],[],[]]",
                             "[[1e300,1,1,1,1,1,1],[1,1,1,1,1,1,1],[1,1,1,1,1,1,1]]"}) {
    json::object bad = good;
    bad.at("calibration").as_object().at("model_error").as_object()["growth"] = json::parse(damage);
    const auto back = ParseOptions(json::serialize(bad), paper::Bench());
    ASSERT_FALSE(back.ok()) << damage;
    EXPECT_NE(back.error().message.find("growth"), std::string::npos) << back.error().message;
  }
  options.calibration->model_error.walk = {3.0, 0.0, 0.0};  // nothing would be a fault
  const auto wide = ParseOptions(OptionsText(options), paper::Bench());
  ASSERT_FALSE(wide.ok());
  EXPECT_NE(wide.error().message.find("walk"), std::string::npos) << wide.error().message;
}

TEST_F(RecordingsTest, DamagedOptionsAreRefusedByMember) {
  for (const char* damage : {"", "[]", "{}", R"({"nominal":{"R1":1}})"}) {
    const auto parsed = ParseOptions(damage, paper::Bench());
    ASSERT_FALSE(parsed.ok()) << damage;
    EXPECT_NE(parsed.error().message.find("member "), std::string::npos) << parsed.error().message;
  }
  json::object whole = json::parse(OptionsText(paper::Options())).as_object();
  for (const auto& [member, value] : json::object(whole)) {
    json::object wrong = whole;
    wrong[member] = json::array{1};
    const auto parsed = ParseOptions(json::serialize(wrong), paper::Bench());
    ASSERT_FALSE(parsed.ok()) << member;
  }
}

TEST_F(RecordingsTest, AFigureDrawsTheVerdictThatTheRunHasStored) {
  const RunRecord record = RunOfARealBench();
  EXPECT_EQ(ValueFound(record.diagnosis_json), 100.0);
  const Figure figure = Draw(record.id, "signals");
  ASSERT_NE(Find(figure, MarkKind::kDetected), nullptr);
  EXPECT_NE(Find(figure, MarkKind::kDetected)->label.find("= 100 Ω"), std::string::npos)
      << Find(figure, MarkKind::kDetected)->label;

  // Nothing is fitted again: another stored verdict gives another picture.
  json::object other = json::parse(record.diagnosis_json).as_object();
  other["detected_at_s"] = 12.5;
  other.at("episodes").as_array().front().as_object()["detected_at_s"] = 12.5;
  ASSERT_TRUE(store_->ReplaceDiagnosis(record.id, json::serialize(other), "fault").ok());
  const Figure changed = Draw(record.id, "signals");
  ASSERT_NE(Find(changed, MarkKind::kDetected), nullptr);
  EXPECT_EQ(Find(changed, MarkKind::kDetected)->x, 12.5);
}

TEST_F(RecordingsTest, TheModelsOfAFigureFitAsTheRunHasStored) {
  const RunRecord record = RunOfARealBench();
  auto parsed = ParseDiagnosis(record.diagnosis_json, paper::Bench()).value();
  const Recording recording = recordings_.Load(record).value();
  core::Diagnosis made = core::DiagnoseRecord(recording.samples, recording.options);
  EXPECT_EQ(parsed.verdict.candidates.front().component, made.verdict.candidates.front().component);
  for (std::size_t i = 0; i < core::kEstimatorCount; ++i) {
    for (std::size_t p = 0; p < 3; ++p) {
      EXPECT_DOUBLE_EQ(parsed.estimates[i].theta[p], made.estimates[i].theta[p]) << i;
      EXPECT_DOUBLE_EQ(parsed.nominal_estimates[i][p], made.nominal_estimates[i][p]) << i;
    }
    EXPECT_EQ(parsed.estimates[i].status, made.estimates[i].status) << i;
  }
  EXPECT_EQ(parsed.episodes.size(), made.episodes.size());
  const Figure models = Draw(record.id, "models");
  EXPECT_FALSE(models.panels.empty());
}

TEST_F(RecordingsTest, ARunThatACrashHasCutIsDiagnosedByItsOwnOptions) {
  const RunRecord whole = RunOfARealBench();
  RunRecord cut = whole;
  cut.id = "run-cut";
  cut.state = RunState::kRunning;
  cut.diagnosis_json.clear();
  cut.verdict.clear();
  ASSERT_TRUE(store_->Begin(cut).ok());
  const auto samples = store_->LoadSamples(whole.id).value();
  ASSERT_TRUE(store_->AppendChunk(cut.id, 0, samples).ok());
  const auto interrupted =
      database_->Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
        InterruptRuns(tx, whole.server_id, clock_.Wall());
        return core::Done{};
      });
  ASSERT_TRUE(interrupted.ok());
  const RunRecord found = store_->Get(cut.id).value();
  ASSERT_EQ(found.state, RunState::kInterrupted);
  const auto text = recordings_.DiagnosisText(found);
  ASSERT_TRUE(text.ok()) << text.error().message;
  EXPECT_EQ(ValueFound(text.value()), 100.0) << "any value near it is an answer without";
  EXPECT_EQ(store_->Get(cut.id).value().diagnosis_json, text.value()) << "made once";
}

TEST_F(RecordingsTest, ARecordingOfAnOlderProgramIsReadAsThatProgramDid) {
  RunRecord old;
  old.period_s = 0.02;
  const auto options = OptionsOf(old, paper::Bench());
  ASSERT_TRUE(options.ok());
  EXPECT_EQ(options.value().values, core::ValuePrior::kNone);
  EXPECT_EQ(options.value().period_s, 0.02);
}

TEST_F(RecordingsTest, AnUploadKeepsItsSamplesAndOptions) {
  const RunRecord run = RunToEnd(Paper());
  Recordings::Upload upload;
  upload.name = "mine";
  upload.owner = "user:1";
  upload.options = paper::Options();
  upload.channels = {"uc_v", "um_v"};
  upload.samples = store_->LoadSamples(run.id).value();
  const auto kept = recordings_.Keep(std::move(upload));
  ASSERT_TRUE(kept.ok()) << kept.error().message;
  EXPECT_EQ(kept.value().verdict.kind, core::VerdictKind::kFault);
  const RunRecord record = store_->Get(kept.value().record.id).value();
  EXPECT_EQ(record.samples, 2000);
  EXPECT_EQ(record.server_id, "server-a") << "its end comes with that of its server";
  EXPECT_EQ(record.verdict, "fault");
  EXPECT_FALSE(record.options_json.empty());
  EXPECT_NE(record.diagnosis_json.find("\"channels\":[\"uc_v\",\"um_v\"]"), std::string::npos);
}

TEST_F(RecordingsTest, ABenchIsRenewedEveryDaySoThatNoMemberThinksItForgotten) {
  BenchStore store(*database_);
  const auto erase = [&](Transaction& tx) -> core::Status {
    tx.sql() << "DELETE FROM bench";
    return core::Done{};
  };
  const WallTime first = clock_.Wall();
  ASSERT_TRUE(benches_.Keep(paper::Bench(), first).ok());
  ASSERT_TRUE(database_->Write(Durability::kPromise, erase).ok());
  ASSERT_TRUE(benches_.Keep(paper::Bench(), first + std::chrono::hours(24)).ok());
  EXPECT_EQ(store.Text(paper::Bench().id).value(), paper::Bench().text);
}

}  // namespace
}  // namespace faultlab::server

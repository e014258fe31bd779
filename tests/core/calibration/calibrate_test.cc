#include "core/calibration/calibrate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/signals/random.h"
#include "tests/core/bench_records.h"
#include "tests/paper_rig.h"

namespace faultlab::core {
namespace {

TEST(Calibrate, RecoversARigThatIsOffItsDataSheetFromAllChannels) {
  PlantParameters rig = paper::Plant();
  rig.series_ohm *= 1.04;
  rig.ra_ohm *= 0.96;
  rig.j_kg_m2 *= 1.05;
  rig.ke_v_per_rad_s *= 0.97;
  rig.kt_nm_per_a *= 0.97;
  const auto record = Between(BenchRecord({}, 51, 6.0, rig), 0.5, 5.0);
  const Result<Calibration> result = Calibrate(record, paper::ToCalibrate());
  ASSERT_TRUE(result.ok()) << result.error().message;
  const Calibration& c = result.value();
  EXPECT_NEAR(c.delta_s, 0.0095, 1e-4);
  EXPECT_NEAR(c.nominal.series_ohm, rig.series_ohm, 0.04);
  EXPECT_NEAR(c.nominal.ra_ohm, rig.ra_ohm, 0.05);
  EXPECT_NEAR(c.nominal.j_kg_m2, rig.j_kg_m2, 0.01e-6);
  EXPECT_NEAR(c.nominal.ke_v_per_rad_s, rig.ke_v_per_rad_s, 2e-5);
  EXPECT_NEAR(c.mc_nm, 0.33e-3, 0.08e-3);
  EXPECT_NEAR(c.um_noise_v, 0.015, 0.002);
  EXPECT_NEAR(c.ia_noise_a, 0.001, 0.0002);
  EXPECT_NEAR(c.n_noise_rpm, 0.5, 0.1);
  for (const CalibratedQuantity& quantity : c.quantities) EXPECT_GT(quantity.sigma, 0.0);
}

TEST(Calibrate, LearnsFromALongStretchWhoseBeginningRests) {
  // A long stretch is searched through in a part of it, which must not be this one: a converter
  // that goes to and fro between two steps is no excitation.
  PlantParameters rig = paper::Plant();
  rig.series_ohm *= 1.04;
  rig.ra_ohm *= 0.96;
  std::vector<double> uc = MakePrbs(PrbsSpec{}, 3200, paper::kPeriodS);
  for (std::size_t k = 0; k < 1500; ++k) uc[k] = k % 2 == 0 ? 2.0 : 2.001;
  const auto record = SimulateRecord(paper::Hardware(), rig, uc, {}, 52, paper::kPeriodS);
  const Result<Calibration> result = Calibrate(record, paper::ToCalibrate());
  ASSERT_TRUE(result.ok()) << result.error().message;
  const Calibration& c = result.value();
  EXPECT_NEAR(c.delta_s, 0.0095, 1e-4);
  EXPECT_NEAR(c.nominal.series_ohm, rig.series_ohm, 0.04);
  EXPECT_NEAR(c.nominal.ra_ohm, rig.ra_ohm, 0.05);
  EXPECT_NEAR(c.um_noise_v, 0.015, 0.001);
  EXPECT_NEAR(c.ia_noise_a, 0.001, 0.0001);
}

TEST(Calibrate, LeavesOutNothingThatComesInRows) {
  const auto clean = Between(BenchRecord({}, 55, 20.5), 0.5, 20.5);
  const auto with = [&](int bursts, int length) {
    auto record = clean;
    for (int k = 0; k < 40; ++k) record[static_cast<std::size_t>(37 + 47 * k)].ia_a += 0.03;
    for (int b = 0; b < bursts; ++b) {
      for (int k = 0; k < length; ++k) {
        record[static_cast<std::size_t>(412 + 600 * b + k)].ia_a += 0.03;
      }
    }
    const Result<Calibration> result = Calibrate(record, paper::ToCalibrate());
    EXPECT_TRUE(result.ok()) << result.error().message;
    return result.ok() ? result.value().impulse_share : -1.0;
  };
  EXPECT_GT(with(0, 0), 0.0);
  EXPECT_GT(with(2, 2), 0.0) << "two that follow another among forty";
  EXPECT_EQ(with(2, 4), 0.0) << "the detector would raise an alarm of each";
}

TEST(Calibrate, RefusesFrictionThatPushes) {
  PrbsSpec spec;
  std::vector<double> uc = MakePrbs(spec, 600, 0.01);
  auto record = Between(
      SimulateRecord(paper::Hardware(), paper::Plant(), uc, {}, 53, paper::kPeriodS), 0.5, 5.0);
  for (Sample& sample : record) sample.uc_v -= 0.3;  // what was written is not what was driven
  const Result<Calibration> refused = Calibrate(record, paper::ToCalibrate());
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().field, "friction") << refused.error().message;
  EXPECT_NE(refused.error().message.find("offset of uc"), std::string::npos);
}

TEST(Calibrate, TellsOfEveryChannelWhatIsLeftOfIt) {
  auto record = Between(BenchRecord({}, 54, 6.0), 0.5, 5.0);
  Random random(9);
  for (Sample& sample : record) sample.ia_a += 0.01 * random.Normal();
  const Result<Calibration> result = Calibrate(record, paper::ToCalibrate());
  ASSERT_TRUE(result.ok()) << result.error().message;
  const auto& checks = result.value().checks;
  const auto told = std::find_if(
      checks.begin(), checks.end(), [](const auto& check) { return check.name == "noise of ia"; });
  ASSERT_NE(told, checks.end());
  EXPECT_EQ(told->sentence.find("0.01"), 0U) << told->sentence;
  EXPECT_NE(told->sentence.find(" times the 0.001 A"), std::string::npos) << told->sentence;
}

TEST(Calibrate, SaysOfWhichChannelTheReadingsComeInSteps) {
  const auto steps_of = [](const std::vector<Sample>& record) {
    const Result<Calibration> result = Calibrate(record, paper::ToCalibrate());
    EXPECT_TRUE(result.ok());
    std::string said;
    for (const CalibrationCheck& check : result.value().checks) {
      if (check.name.starts_with("steps of ")) said += check.sentence;
    }
    return said;
  };
  auto record = Between(BenchRecord({}, 54, 6.0), 0.5, 5.0);
  EXPECT_EQ(steps_of(record), "");
  for (Sample& sample : record) sample.n_rpm = 3.0 * std::round(sample.n_rpm / 3.0);
  EXPECT_EQ(steps_of(record).find("n comes in steps of 3 rpm: "), 0U) << steps_of(record);
  record[100].n_rpm += 1.0;  // then they do not
  EXPECT_EQ(steps_of(record), "");
}

TEST(Calibrate, FindsDeltaOfBothProfiles) {
  PrbsSpec spec;
  const std::vector<double> uc = MakePrbs(spec, 600, 0.01);
  for (const BenchProfile& profile : {paper::Hardware(), paper::CircuitSimulation()}) {
    const auto record =
        Between(SimulateRecord(profile, paper::Plant(), uc, {}, 52, paper::kPeriodS), 0.5, 5.0);
    for (Channels channels : {Channels::kUmOnly, Channels::kAll}) {
      CalibrationOptions options = paper::ToCalibrate();
      options.channels = channels;
      const Result<Calibration> result = Calibrate(record, options);
      ASSERT_TRUE(result.ok()) << result.error().message;
      EXPECT_NEAR(
          result.value().delta_s, profile.delta_s, channels == Channels::kAll ? 1e-4 : 1e-3);
    }
  }
}

TEST(Calibrate, BelievesAMeasuredDelta) {
  PrbsSpec spec;
  const std::vector<double> uc = MakePrbs(spec, 600, paper::kPeriodS);
  BenchProfile slow = paper::Hardware();
  slow.delta_s = 5.2e-3;  // of slow converters; the description says 9.5 ms
  auto record =
      Between(SimulateRecord(slow, paper::Plant(), uc, {}, 52, paper::kPeriodS), 0.5, 5.0);
  CalibrationOptions options = paper::ToCalibrate();
  options.channels = Channels::kUmOnly;
  const auto delta_of = [&] {
    const Result<Calibration> result = Calibrate(record, options);
    EXPECT_TRUE(result.ok());
    return result.value().quantities[static_cast<std::size_t>(Coordinate::kDelta)];
  };
  const CalibratedQuantity guessed = delta_of();
  for (std::size_t k = 0; k < record.size(); ++k) {
    record[k].delta_s = 5.2e-3 + (k % 2 == 0 ? 5e-5 : -5e-5);
  }
  const CalibratedQuantity measured = delta_of();
  EXPECT_NEAR(measured.value, 5.2e-3, 1e-4);
  EXPECT_NEAR(measured.prior_value, 5.2e-3, 1e-6);
  EXPECT_LT(measured.sigma, 0.5 * guessed.sigma);
}

TEST(Calibrate, SaysWhatTheChannelsCannotSee) {
  const auto record = Between(BenchRecord({}, 53, 6.0), 0.5, 5.0);
  CalibrationOptions options = paper::ToCalibrate();
  options.channels = Channels::kUmOnly;
  const Result<Calibration> result = Calibrate(record, options);
  ASSERT_TRUE(result.ok());
  for (const CalibratedQuantity& quantity : result.value().quantities) {
    if (quantity.name == "k") {
      EXPECT_TRUE(quantity.from_data);
    }
    if (quantity.name == "B" || quantity.name == "R1") {
      EXPECT_FALSE(quantity.from_data);
    }
  }
}

TEST(Calibrate, TakesAStretchWhoseLastSampleFollowsAGap) {
  std::vector<Sample> stretch = Between(BenchRecord({}, 60, 6.0), 0.5, 5.0);
  const Result<Calibration> whole = Calibrate(stretch, paper::ToCalibrate());
  stretch.erase(stretch.end() - 2);
  const Result<Calibration> gap = Calibrate(stretch, paper::ToCalibrate());
  ASSERT_TRUE(whole.ok() && gap.ok()) << gap.error().message;
  EXPECT_NEAR(gap.value().um_noise_v, whole.value().um_noise_v, 0.02 * whole.value().um_noise_v);
  EXPECT_NEAR(gap.value().nominal.j_kg_m2, whole.value().nominal.j_kg_m2, 2e-9);
}

TEST(Calibrate, RefusesByNamingTheCheck) {
  const auto refusal = [](const std::vector<Sample>& samples) {
    const Result<Calibration> result = Calibrate(samples, paper::ToCalibrate());
    return result.ok() ? std::string("accepted") : result.error().field;
  };
  EXPECT_EQ(refusal({}), "length");
  EXPECT_EQ(refusal(Between(BenchRecord({}, 54, 6.0), 0.5, 1.5)), "length");
  std::vector<double> constant(600, 2.5);
  EXPECT_EQ(
      refusal(Between(
          SimulateRecord(paper::Hardware(), paper::Plant(), constant, {}, 55, paper::kPeriodS),
          0.5,
          5.0)),
      "excitation");
  std::vector<double> ramp(600);
  for (std::size_t k = 0; k < ramp.size(); ++k) ramp[k] = 2.0 + 0.002 * static_cast<double>(k);
  EXPECT_EQ(refusal(Between(
                SimulateRecord(paper::Hardware(), paper::Plant(), ramp, {}, 55, paper::kPeriodS),
                0.5,
                5.0)),
            "excitation");
  std::vector<Sample> silent = Between(BenchRecord({}, 56, 6.0), 0.5, 5.0);
  for (std::size_t k = 0; k < silent.size(); k += 2) silent[k].um_v = kAbsent;
  EXPECT_EQ(refusal(silent), "missing");
  PlantParameters loud = paper::Plant();
  loud.Set(paper::kR12, 18e3);
  EXPECT_EQ(refusal(Between(BenchRecord({}, 57, 6.0, loud), 0.5, 5.0)), "saturation");
  EXPECT_EQ(refusal(Between(BenchRecord({AbruptFault(paper::kRa, 9.0, 3.0)}, 58, 6.0), 0.5, 5.0)),
            "stationarity");
  PlantParameters other = paper::Plant();
  other.j_kg_m2 = 4e-6;
  EXPECT_EQ(refusal(Between(BenchRecord({}, 59, 6.0, other), 0.5, 5.0)), "tolerance");
}

TEST(Calibrate, SaysWhatChangesInsideTheStretch) {
  const auto refusal = [](const Fault& fault) {
    const Result<Calibration> result =
        Calibrate(Between(BenchRecord({fault}, 71, 40.0), 0.5, 40.0), paper::ToCalibrate());
    return result.ok() ? std::string("accepted") : result.error().message;
  };
  Fault warming = AbruptFault(paper::kRa, 1.03 * paper::Plant().ra_ohm, 0.0);
  warming.kind = FaultKind::kDrift;
  warming.until_s = 40.0;
  const Result<Calibration> warm =
      Calibrate(Between(BenchRecord({warming}, 71, 40.0), 0.5, 40.0), paper::ToCalibrate());
  ASSERT_TRUE(warm.ok()) << warm.error().message;
  EXPECT_NEAR(warm.value().model_error.walk[0], 0.0225, 0.003) << "of the quarters' means";
  const auto said = std::ranges::find(warm.value().checks, "stationarity", &CalibrationCheck::name);
  ASSERT_NE(said, warm.value().checks.end());
  EXPECT_NE(said->sentence.find("Ra by +2."), std::string::npos) << said->sentence;
  EXPECT_NE(said->sentence.find("as a rig that warms up"), std::string::npos);
  const auto ra = std::ranges::find(warm.value().quantities, "Ra", &CalibratedQuantity::name);
  EXPECT_GT(ra->sigma, 0.02 * ra->value) << "no single value is stated closer than it walks";
  // A step is none, though it is as small, nor is another part.
  const std::string step = refusal(AbruptFault(paper::kRa, 1.03 * paper::Plant().ra_ohm, 20.0));
  EXPECT_NE(step.find("Ra changes by +"), std::string::npos) << step;
  EXPECT_EQ(step.find("warms up"), std::string::npos) << step;
  const std::string other = refusal(AbruptFault(paper::kJ, 1.1 * paper::Plant().j_kg_m2, 20.0));
  EXPECT_NE(other.find("J changes by +"), std::string::npos) << other;
}

}  // namespace
}  // namespace faultlab::core

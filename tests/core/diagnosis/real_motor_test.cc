// Motors that are not quite the model: what a calibration says of itself, and what follows from it.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "core/calibration/calibrate.h"
#include "core/detection/detection_thresholds.h"
#include "core/diagnosis/diagnose_record.h"
#include "core/diagnosis/pipeline.h"
#include "tests/core/diagnosis/real_motors.h"
#include "tests/core/diagnosis/verdicts.h"
#include "tests/support/scale.h"

namespace faultlab::core {
namespace {

constexpr double kLearnS = 20.0;
constexpr double kWatchS = 40.0;

using Samples = std::vector<Sample>;

Setting SettingOf(const std::string& name) {
  for (const Setting& setting : Settings()) {
    if (setting.name == name) return setting;
  }
  throw std::invalid_argument(name);
}

Rig WithPhysics(Rig rig, const std::string& kind) {
  for (const PhysicsKind& each : KindsFor(rig)) {
    if (each.name == kind) {
      rig.physics = each.physics;
      return rig;
    }
  }
  throw std::invalid_argument(kind);
}

Samples Before(const Samples& record, double t_s) {
  Samples part;
  std::copy_if(record.begin(), record.end(), std::back_inserter(part), [&](const Sample& sample) {
    return sample.t_s >= 0.5 && sample.t_s < t_s - 1e-9;
  });
  return part;
}

Samples From(const Samples& record, double t_s) {
  Samples part;
  std::copy_if(record.begin(), record.end(), std::back_inserter(part), [&](const Sample& sample) {
    return sample.t_s >= t_s - 1e-9;
  });
  return part;
}

CalibrationOptions ToLearn(const Bench& bench) {
  CalibrationOptions options;
  options.bench = &bench;
  options.data_sheet = bench.nominal;
  options.period_s = bench.period_s;
  options.um_rail_v = bench.um.exists ? bench.um.max : options.um_rail_v;
  return options;
}

Result<Calibration> Learn(const Bench& bench, const Samples& stretch) {
  return Calibrate(stretch, ToLearn(bench));
}

DetectionThresholds NoiseAlone(const Calibration& calibration) {
  const unsigned mask = (calibration.used_um ? 1U : 0U) | (calibration.used_ia ? 2U : 0U) |
                        (calibration.used_n ? 4U : 0U);
  return MakeThresholds(
      calibration.thresholds.false_alarms_per_day, 1.0 / calibration.period_s, mask);
}

DiagnosisOptions With(const Bench& bench, const Calibration& calibration) {
  DiagnosisOptions options = OptionsOf(bench);
  options.calibration = calibration;
  return options;
}

const CalibrationCheck* Find(const Calibration& calibration, const std::string& name) {
  const auto found = std::find_if(calibration.checks.begin(),
                                  calibration.checks.end(),
                                  [&](const auto& check) { return check.name == name; });
  return found != calibration.checks.end() ? &*found : nullptr;
}

TEST(RealMotor, IdealOneKeepsTheLevelsOfNoiseAlone) {
  for (const Setting& setting : Settings()) {
    for (const unsigned seed : tests::Seeds(1, 5)) {
      const Samples record = RecordFor(setting.rig, setting.rig, 1e9, kLearnS, seed);
      const Result<Calibration> learnt = Learn(*setting.bench, Before(record, kLearnS));
      ASSERT_TRUE(learnt.ok()) << learnt.error().message;
      const Calibration& c = learnt.value();
      EXPECT_EQ(c.thresholds.glr_long, NoiseAlone(c).glr_long) << setting.name << ' ' << seed;
      EXPECT_EQ(c.thresholds.residual, NoiseAlone(c).residual) << setting.name << ' ' << seed;
      EXPECT_EQ(c.model_error, ModelError{}) << setting.name << ' ' << seed;
      const CalibrationCheck* own = Find(c, "own stretch");
      ASSERT_NE(own, nullptr);
      EXPECT_NE(own->sentence.find("raises no alarm"), std::string::npos) << own->sentence;
    }
  }
}

TEST(RealMotor, RaisesNoAlarmWhileItIsHealthyAndFaultsAreStillNamed) {
  int with_noise_alone = 0;
  unsigned seed = 20;
  for (const auto& [name, kind] : {std::pair{"gear", "brush V"},
                                   {"gear", "brush R"},
                                   {"gear", "sag"},
                                   {"gear+um", "brush w"},
                                   {"paper", "brush R"},
                                   {"paper", "sag"}}) {
    SCOPED_TRACE(std::string(name) + ", " + kind);
    const Setting setting = SettingOf(name);
    const Rig rig = WithPhysics(setting.rig, kind);
    const Samples record = RecordFor(rig, rig, 1e9, kLearnS + kWatchS, ++seed, 5);
    const Result<Calibration> learnt = Learn(*setting.bench, Before(record, kLearnS));
    ASSERT_TRUE(learnt.ok()) << learnt.error().message;
    Calibration c = learnt.value();
    EXPECT_GT(std::ranges::max(c.model_error.raised[1]), 1.0);
    const DiagnosisOptions options = With(*setting.bench, c);
    EXPECT_EQ(AlarmsRaised(Before(record, kLearnS), options), 0) << "on what it has learnt from";
    EXPECT_EQ(AlarmsRaised(From(record, kLearnS), options), 0);

    Rig faulty = rig;
    faulty.ra *= 1.5;
    const Samples later = RecordFor(rig, faulty, kLearnS, kLearnS + 10.0, seed, 5);
    const Verdict verdict = DiagnoseRecord(From(later, kLearnS - 3.0), options).verdict;
    EXPECT_EQ(verdict.kind, VerdictKind::kFault) << verdict.reason;
    EXPECT_TRUE(Names(verdict, setting.bench->Find("Ra").value())) << verdict.reason;
    EXPECT_GE(verdict.detected_at_s.value_or(0.0), kLearnS - 1e-9);

    c.thresholds = NoiseAlone(c);
    c.model_error = {};
    with_noise_alone += AlarmsRaised(From(record, kLearnS), With(*setting.bench, c));
  }
  EXPECT_GT(with_noise_alone, 5) << "these motors are not quite the model";
}

TEST(RealMotor, CoulombFrictionThatDoublesIsNamedAndIsNoListedPart) {
  Rig rig = SettingOf("paper").rig;
  rig.low_v = 2.0;
  rig.high_v = 3.0;
  rig.clock = 1;
  rig.mc = 0.35e-3;
  Rig faulty = rig;
  faulty.mc = 0.7e-3;
  for (const unsigned seed : tests::Seeds(51, 57)) {
    const Verdict verdict =
        DiagnoseRecord(RecordFor(rig, faulty, 10.0, 20.0, seed), paper::Options()).verdict;
    SCOPED_TRACE(std::to_string(seed) + ": " + verdict.reason);
    EXPECT_EQ(verdict.kind, VerdictKind::kUnknownFault);
    ASSERT_TRUE(verdict.friction);
    EXPECT_FALSE(verdict.sensor);
    EXPECT_NEAR(verdict.friction->before_nm, rig.mc, 0.1 * rig.mc);
    EXPECT_NEAR(verdict.friction->after_nm, faulty.mc, 4.0 * verdict.friction->sigma_nm);
    EXPECT_LT(verdict.friction->sigma_nm, 0.1 * faulty.mc);
    EXPECT_NE(verdict.reason.find("dry friction takes "), std::string::npos);
  }
}

TEST(RealMotor, ViscousFrictionIsNotTakenForDryFriction) {
  unsigned seed = 70;
  for (const Setting& setting : Settings()) {
    Rig faulty = setting.rig;
    faulty.b += 2.0 * setting.rig.mc / (setting.rig.k * setting.rig.high_v / setting.rig.ke);
    const Verdict verdict = DiagnoseRecord(RecordFor(setting.rig, faulty, 12.0, 22.0, ++seed, 5),
                                           OptionsOf(*setting.bench))
                                .verdict;
    SCOPED_TRACE(std::string(setting.name) + ": " + verdict.reason);
    EXPECT_EQ(verdict.kind, VerdictKind::kFault);
    EXPECT_EQ(Name(NamedBy(verdict).front()), "B");
    EXPECT_FALSE(verdict.friction);
  }
}

TEST(RealMotor, SupplyThatGivesWayIsNotTakenForImpulses) {
  // After each step of the input some readings are far off, one after the other.
  const Setting setting = SettingOf("gear+um");
  const Rig rig = WithPhysics(setting.rig, "sag");
  const Samples record = RecordFor(rig, rig, 1e9, kLearnS + kWatchS, 32, 5);
  const Result<Calibration> learnt = Learn(*setting.bench, Before(record, kLearnS));
  ASSERT_TRUE(learnt.ok()) << learnt.error().message;
  EXPECT_EQ(learnt.value().impulse_share, 0.0);
  EXPECT_EQ(Find(learnt.value(), "impulses"), nullptr);
  EXPECT_EQ(AlarmsRaised(From(record, kLearnS), With(*setting.bench, learnt.value())), 0);
}

TEST(RealMotor, RigThatWarmsUpIsLearntAsOneAndRaisesNoAlarm) {
  constexpr double kLongS = 2.0 * kLearnS;
  unsigned seed = 60;
  for (const char* name : {"gear", "gear+um", "paper"}) {
    SCOPED_TRACE(name);
    const Setting setting = SettingOf(name);
    const Rig rig = WithPhysics(setting.rig, "warming");
    const Samples record = RecordFor(rig, rig, 1e9, kLongS + kLearnS, ++seed, 5);
    const Result<Calibration> learnt = Learn(*setting.bench, Before(record, kLongS));
    ASSERT_TRUE(learnt.ok()) << learnt.error().message;
    const double ra = learnt.value().model_error.walk[0];
    const double ke = learnt.value().model_error.walk[1];
    // Three quarters of the way, as the quarters' means tell it; Ke by half of it, the other way.
    const double way = 0.75 * rig.physics.warming_per_s * (kLongS - 0.5);
    EXPECT_NEAR(ra, way, 0.3 * way);
    EXPECT_NEAR(ke, -rig.physics.magnet * way, 0.3 * way);
    const DiagnosisOptions options = With(*setting.bench, learnt.value());
    EXPECT_EQ(AlarmsRaised(Before(record, kLongS), options), 0) << "on what it has learnt from";
    EXPECT_EQ(AlarmsRaised(From(record, kLongS), options), 0);

    Rig faulty = rig;
    faulty.ra *= 1.2;
    const Samples later = RecordFor(rig, faulty, kLongS, kLongS + 10.0, seed, 5);
    const Verdict verdict = DiagnoseRecord(From(later, kLongS - 3.0), options).verdict;
    EXPECT_TRUE(Names(verdict, setting.bench->Find("Ra").value())) << verdict.reason;
    EXPECT_GE(verdict.detected_at_s.value_or(0.0), kLongS - 1e-9);
    EXPECT_LT(verdict.detected_at_s.value_or(1e9), kLongS + 1.0);
  }
}

TEST(RealMotor, FaultIsNamedWhereTheInputRestsForSeconds) {
  // Most of what follows an alarm is then a motor that turns steadily.
  const Setting setting = SettingOf("gear+um");
  Rig rig = WithPhysics(setting.rig, "brush R");
  rig.clock = static_cast<int>(std::lround(2.0 / rig.period_s));
  constexpr double kLongS = 2.0 * kLearnS;
  const Samples record = RecordFor(rig, rig, 1e9, kLongS, 43, 5);
  const Result<Calibration> learnt = Learn(*setting.bench, Before(record, kLongS));
  ASSERT_TRUE(learnt.ok()) << learnt.error().message;
  const DiagnosisOptions options = With(*setting.bench, learnt.value());
  for (const auto& [symbol, change] : {std::pair{"J", &Rig::j}, {"Ra", &Rig::ra}}) {
    Rig faulty = rig;
    faulty.*change *= 1.4;
    const Samples later = RecordFor(rig, faulty, kLearnS, kLearnS + 12.0, 44, 5);
    const Verdict verdict = DiagnoseRecord(From(later, kLearnS - 3.0), options).verdict;
    EXPECT_TRUE(Names(verdict, setting.bench->Find(symbol).value()))
        << symbol << ": " << verdict.reason;
  }
}

TEST(RealMotor, HalfWithoutStepsJudgesNothing) {
  const Setting setting = SettingOf("gear");
  Rig still = setting.rig;
  still.high_v = still.low_v;
  const double first_quarter_s = 0.25 * kLearnS;
  const Samples record = RecordFor(setting.rig, still, first_quarter_s, kLearnS, 41);
  const Result<Calibration> learnt = Learn(*setting.bench, Before(record, kLearnS));
  ASSERT_TRUE(learnt.ok()) << learnt.error().message;
  const CalibrationCheck* own = Find(learnt.value(), "own stretch");
  ASSERT_NE(own, nullptr) << "in silence nobody knows what the levels are";
  EXPECT_NE(own->sentence.find("steps too seldom"), std::string::npos) << own->sentence;
  EXPECT_EQ(learnt.value().thresholds.glr_long, NoiseAlone(learnt.value()).glr_long);
}

double SigmasOff(const Calibration& calibration, const char* name, double truth) {
  for (const CalibratedQuantity& q : calibration.quantities) {
    if (q.name == name) return std::abs(q.value - truth) / q.sigma;
  }
  return 1e9;
}

double ShareOf(const Calibration& calibration, const char* name) {
  for (const CalibratedQuantity& q : calibration.quantities) {
    if (q.name == name) return q.sigma / q.value;
  }
  return 1e9;
}

/// How many of some stated values are within two of their errors.
struct Coverage {
  int within = 0;
  int all = 0;
  void Add(double sigmas) {
    within += sigmas <= 2.0;
    ++all;
  }
};

TEST(RealMotor, StatedErrorsCoverWhatTheModelLacks) {
  unsigned seed = 60;
  Coverage stated;
  Coverage by_noise_alone;
  for (const char* name : {"gear", "gear+um"}) {
    for (const char* kind : {"brush w", "brush V", "brush R", "sag", "tacho", "fan"}) {
      SCOPED_TRACE(std::string(name) + ", " + kind);
      const Setting setting = SettingOf(name);
      const Rig rig = WithPhysics(setting.rig, kind);
      Rig faulty = rig;
      faulty.ra *= 1.5;
      const Samples record = RecordFor(rig, faulty, kLearnS, kLearnS + 10.0, ++seed);
      const Result<Calibration> learnt = Learn(*setting.bench, Before(record, kLearnS));
      ASSERT_TRUE(learnt.ok()) << learnt.error().message;
      Calibration c = learnt.value();
      stated.Add(SigmasOff(c, "Ra", rig.ra));
      stated.Add(SigmasOff(c, "Ke", rig.ke));
      stated.Add(SigmasOff(c, "J", rig.j));
      const auto fault = [&] {
        const Verdict verdict =
            DiagnoseRecord(From(record, kLearnS - 3.0), With(*setting.bench, c)).verdict;
        if (verdict.candidates.empty()) return 1e9;
        const Candidate& best = verdict.candidates.front();
        return std::abs(best.value - faulty.ra) / best.sigma;
      };
      stated.Add(fault());
      c.model_covariance.clear();
      by_noise_alone.Add(fault());
    }
  }
  EXPECT_GE(stated.within, 0.9 * stated.all) << stated.all;
  EXPECT_LE(by_noise_alone.within, 0.6 * by_noise_alone.all) << by_noise_alone.all;
}

Bench WithExactScales(Bench bench) {
  bench.um.gain_sd = bench.ia.gain_sd = 0.0;
  return bench;
}

TEST(RealMotor, StatedErrorsCoverAScaleThatIsOff) {
  const Setting setting = SettingOf("gear+um");
  const Bench exact = WithExactScales(*setting.bench);
  const Rig& rig = setting.rig;
  Coverage stated;
  Coverage by_exact_scales;
  unsigned seed = 80;
  for (double Sample::*channel : {&Sample::um_v, &Sample::ia_a}) {
    for (const double factor : {0.993, 1.007}) {
      Samples record = RecordFor(rig, rig, 1e9, kLearnS, ++seed, 5);
      for (Sample& sample : record) sample.*channel *= factor;
      for (const auto& [bench, coverage] :
           {std::pair{setting.bench, &stated}, {&exact, &by_exact_scales}}) {
        const Result<Calibration> learnt = Learn(*bench, Before(record, kLearnS));
        ASSERT_TRUE(learnt.ok()) << learnt.error().message;
        coverage->Add(SigmasOff(learnt.value(), "Ra", rig.ra));
        coverage->Add(SigmasOff(learnt.value(), "Ke", rig.ke));
        coverage->Add(SigmasOff(learnt.value(), "J", rig.j));
      }
    }
  }
  EXPECT_GE(stated.within, 0.9 * stated.all) << stated.all;
  EXPECT_LE(by_exact_scales.within, 0.6 * by_exact_scales.all) << by_exact_scales.all;
}

TEST(RealMotor, IdealMotorPaysLittleForIt) {
  for (const char* name : {"gear", "gear+um"}) {
    const Setting setting = SettingOf(name);
    const Bench exact = WithExactScales(*setting.bench);
    CalibrationOptions options = ToLearn(exact);
    const Samples record = RecordFor(setting.rig, setting.rig, 1e9, kLearnS, 71, 5);
    const Calibration with = Calibrate(Before(record, kLearnS), options).value();
    options.model = ModelScope::kSimulator;
    const Calibration without = Calibrate(Before(record, kLearnS), options).value();
    for (const char* quantity : {"Ra", "Ke", "J"}) {
      EXPECT_LT(ShareOf(with, quantity), 2.0 * ShareOf(without, quantity) + 0.002)
          << name << ' ' << quantity;
    }
  }
}

TEST(RealMotor, SimulatorsHaveNoMissingPhysics) {
  const Setting setting = SettingOf("gear");
  const Samples record = RecordFor(setting.rig, setting.rig, 1e9, kLearnS, 81);
  DiagnosisOptions options = OptionsOf(*setting.bench);
  options.model = ModelScope::kSimulator;
  const Diagnosis exact = DiagnoseRecord(record, options);
  ASSERT_TRUE(exact.calibration.has_value());
  EXPECT_TRUE(exact.calibration->model_covariance.empty());
  options.model = ModelScope::kAsDescribed;
  const Diagnosis real = DiagnoseRecord(record, options);
  ASSERT_TRUE(real.calibration.has_value());
  EXPECT_LT(ShareOf(*exact.calibration, "Ra"), ShareOf(*real.calibration, "Ra"));
  EXPECT_EQ(exact.verdict.kind, VerdictKind::kNominal);
}

TEST(RealMotor, BuiltRigHasMissingPhysicsWhateverItsDescriptionSays) {
  const Setting setting = SettingOf("paper");
  const Samples record = RecordFor(setting.rig, setting.rig, 1e9, kLearnS, 83);
  DiagnosisOptions options = OptionsOf(paper::Bench());
  options.model = ModelScope::kBuiltRig;
  const Diagnosis built = DiagnoseRecord(record, options);
  options.model = ModelScope::kAsDescribed;
  const Diagnosis described = DiagnoseRecord(record, options);
  ASSERT_TRUE(built.calibration && described.calibration);
  EXPECT_TRUE(described.calibration->model_covariance.empty());
  EXPECT_GT(ShareOf(*built.calibration, "Ra"), ShareOf(*described.calibration, "Ra"));
}

// "an alarm follows a change of Ra from 2 %, Ke from 0.92 %, .."
double VisiblePercent(const Calibration& calibration, const std::string& symbol) {
  const CalibrationCheck* check = Find(calibration, "visible");
  if (check == nullptr) return 0.0;
  const std::size_t at = check->sentence.find(" " + symbol + " from ");
  if (at == std::string::npos) return 0.0;
  return std::stod(check->sentence.substr(at + symbol.size() + 7));
}

TEST(RealMotor, SmallestChangeThatIsStatedIsSeenAndAThirdOfItIsNot) {
  for (const auto& [name, kind] :
       {std::pair{"gear", "ideal"}, {"gear", "brush R"}, {"paper", "all"}}) {
    SCOPED_TRACE(std::string(name) + ", " + kind);
    const Setting setting = SettingOf(name);
    const Rig rig = WithPhysics(setting.rig, kind);
    const Result<Calibration> learnt =
        Learn(*setting.bench, Before(RecordFor(rig, rig, 1e9, kLearnS, 51), kLearnS));
    ASSERT_TRUE(learnt.ok()) << learnt.error().message;
    const DiagnosisOptions options = With(*setting.bench, learnt.value());
    for (const auto& [symbol, value] : {std::pair{"Ra", &Rig::ra}, {"J", &Rig::j}}) {
      const double percent = VisiblePercent(learnt.value(), symbol);
      ASSERT_GT(percent, 0.0) << Find(learnt.value(), "visible")->sentence;
      for (const double share : {1.5, 0.33}) {
        Rig faulty = rig;
        faulty.*value *= 1.0 + share * 0.01 * percent;
        const Samples later = RecordFor(rig, faulty, kLearnS, kLearnS + 20.0, 52);
        EXPECT_EQ(AlarmsRaised(From(later, kLearnS - 3.0), options) > 0, share > 1.0)
            << share << " of " << symbol << " from " << percent << " %";
      }
    }
  }
}

}  // namespace
}  // namespace faultlab::core

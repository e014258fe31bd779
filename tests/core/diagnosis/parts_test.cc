#include <gtest/gtest.h>

#include <cmath>

#include "core/diagnosis/calibration.h"
#include "core/diagnosis/detector.h"
#include "core/diagnosis/innovation_filter.h"
#include "core/diagnosis/paper_methods.h"
#include "core/plant/sampled_model.h"
#include "core/signals/random.h"
#include "tests/core/diagnosis/diagnosis_records.h"

namespace faultlab::core {
namespace {

std::vector<Sample> Between(const std::vector<Sample>& record, double from_s, double to_s) {
  std::vector<Sample> part;
  for (const Sample& sample : record) {
    if (sample.t_s >= from_s && sample.t_s < to_s) part.push_back(sample);
  }
  return part;
}

// ---- the prediction model

TEST(PredictionModel, AgreesWithThePlantsOwnSampledModel) {
  RigParameters rig;
  rig.plant.c8_farad = 2.2e-6;
  rig.plant.r1_ohm = 10.0;
  rig.mc_nm = 0.33e-3;
  const PredictionModel mine = MakePredictionModel(rig, NoiseLevel{}, 0.01);
  const SampledModel other = MakeSampledModel(rig.plant, 0.01, rig.delta_s);
  PrbsSpec spec;
  const std::vector<double> uc = MakePrbs(spec, 400, 0.01);
  Eigen::Vector3d x_other = Eigen::Vector3d::Zero();
  Eigen::Vector4d x = Eigen::Vector4d::Zero();
  double worst = 0.0;
  for (std::size_t k = 0; k < uc.size(); ++k) {
    const Eigen::Vector3d y_other = other.c * x_other + other.d_u * uc[k] + other.d_m * rig.mc_nm;
    const Eigen::Vector3d next_other =
        other.phi * x_other + other.gamma_u * uc[k] + other.gamma_m * rig.mc_nm;
    x_other = next_other;
    const Eigen::Vector4d next = mine.phi * x + mine.g_prev * uc[k == 0 ? 0 : k - 1] +
                                 mine.g * uc[k] + mine.g_torque * rig.mc_nm;
    x = next;
    const Eigen::Vector3d y = mine.c * x + mine.d * uc[k];
    // The first samples differ by the start: one counts from the edge, the other from the reading.
    if (k > 100) worst = std::max(worst, (y - y_other).cwiseAbs().maxCoeff());
  }
  EXPECT_LT(worst, 1e-6);
}

TEST(InnovationFilter, LeavesWhiteUnitInnovationsOfAHealthyBench) {
  RigParameters rig;
  rig.mc_nm = 0.33e-3;
  const auto record = Between(BenchRecord({}, 41), 0.5, 20.0);
  const auto stretch = MakeObservations(record, Channels::kAll, 0.01, 10.0);
  InnovationTrace trace;
  NoiseLevel noise;
  noise.w_rad_s = 0.5 * kRadPerSecondOfRpm;
  const InnovationSummary sum =
      RunInnovations(MakePredictionModel(rig, noise, 0.01), stretch, &trace);
  ASSERT_EQ(sum.count, 3 * 1950);
  // 5850 readings: chi2/n has a standard deviation of 1.8 %.
  EXPECT_NEAR(sum.chi2 / sum.count, 1.0, 0.12);
  for (std::size_t channel = 0; channel < 3; ++channel) {
    double lag = 0.0;
    double energy = 0.0;
    for (std::size_t k = 20; k < stretch.size(); ++k) {
      const double now = trace.whitened[3 * k + channel];
      lag += now * trace.whitened[3 * (k - 1) + channel];
      energy += now * now;
    }
    // 1900 samples: sd 2.3 %.
    EXPECT_LT(std::abs(lag / energy), 0.1) << channel;
  }
}

TEST(InnovationFilter, ForgetsWhereItStarted) {
  // The same stretch behind a gap of unknown length must cost no more than the first samples.
  const auto record = Between(BenchRecord({}, 42), 0.5, 8.0);
  RigParameters rig;
  rig.mc_nm = 0.33e-3;
  const PredictionModel model = MakePredictionModel(rig, NoiseLevel{}, 0.01);
  std::vector<Sample> cut = record;
  cut.erase(cut.begin() + 300, cut.begin() + 340);
  const auto whole = MakeObservations(record, Channels::kUmOnly, 0.01, 10.0);
  const auto gapped = MakeObservations(cut, Channels::kUmOnly, 0.01, 10.0);
  EXPECT_TRUE(gapped[300].restart);
  const double n = static_cast<double>(gapped.size());
  EXPECT_NEAR(RunInnovations(model, gapped).chi2 / n,
              RunInnovations(model, whole).chi2 / static_cast<double>(whole.size()),
              0.1);
}

// ---- calibration

TEST(Calibrate, RecoversARigThatIsOffItsDataSheetFromAllChannels) {
  PlantParameters rig;
  rig.r1_ohm *= 1.04;
  rig.ra_ohm *= 0.96;
  rig.j_kg_m2 *= 1.05;
  rig.ke_v_per_rad_s *= 0.97;
  rig.kt_nm_per_a *= 0.97;
  const auto record = Between(BenchRecord({}, 51, 6.0, rig), 0.5, 5.0);
  const Result<Calibration> result = Calibrate(record, {});
  ASSERT_TRUE(result.ok()) << result.error().message;
  const Calibration& c = result.value();
  EXPECT_NEAR(c.delta_s, 0.0095, 1e-4);
  EXPECT_NEAR(c.nominal.r1_ohm, rig.r1_ohm, 0.04);
  EXPECT_NEAR(c.nominal.ra_ohm, rig.ra_ohm, 0.05);
  EXPECT_NEAR(c.nominal.j_kg_m2, rig.j_kg_m2, 0.01e-6);
  EXPECT_NEAR(c.nominal.ke_v_per_rad_s, rig.ke_v_per_rad_s, 2e-5);
  EXPECT_NEAR(c.mc_nm, 0.33e-3, 0.08e-3);
  EXPECT_NEAR(c.um_noise_v, 0.015, 0.002);
  EXPECT_NEAR(c.ia_noise_a, 0.001, 0.0002);
  EXPECT_NEAR(c.n_noise_rpm, 0.5, 0.1);
  for (const CalibratedQuantity& quantity : c.quantities) EXPECT_GT(quantity.sigma, 0.0);
}

TEST(Calibrate, FindsDeltaOfBothProfiles) {
  PrbsSpec spec;
  const std::vector<double> uc = MakePrbs(spec, 600, 0.01);
  for (const BenchProfile& profile : {BenchProfileBench(), BenchProfileMultisim()}) {
    const auto record = Between(SimulateRecord(profile, {}, uc, {}, 52), 0.5, 5.0);
    for (Channels channels : {Channels::kUmOnly, Channels::kAll}) {
      CalibrationOptions options;
      options.channels = channels;
      const Result<Calibration> result = Calibrate(record, options);
      ASSERT_TRUE(result.ok()) << result.error().message;
      EXPECT_NEAR(
          result.value().delta_s, profile.delta_s, channels == Channels::kAll ? 1e-4 : 1e-3);
    }
  }
}

TEST(Calibrate, SaysWhatTheChannelsCannotSee) {
  const auto record = Between(BenchRecord({}, 53, 6.0), 0.5, 5.0);
  CalibrationOptions options;
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

TEST(Calibrate, RefusesByNamingTheCheck) {
  const auto refusal = [](const std::vector<Sample>& samples) {
    const Result<Calibration> result = Calibrate(samples, {});
    return result.ok() ? std::string("accepted") : result.error().field;
  };
  EXPECT_EQ(refusal({}), "length");
  EXPECT_EQ(refusal(Between(BenchRecord({}, 54, 6.0), 0.5, 1.5)), "length");
  std::vector<double> constant(600, 2.5);
  EXPECT_EQ(refusal(Between(SimulateRecord(BenchProfileBench(), {}, constant, {}, 55), 0.5, 5.0)),
            "excitation");
  std::vector<Sample> silent = Between(BenchRecord({}, 56, 6.0), 0.5, 5.0);
  for (std::size_t k = 0; k < silent.size(); k += 2) silent[k].um_v = kAbsent;
  EXPECT_EQ(refusal(silent), "missing");
  PlantParameters loud;
  loud.r12_ohm = 18e3;
  EXPECT_EQ(refusal(Between(BenchRecord({}, 57, 6.0, loud), 0.5, 5.0)), "saturation");
  EXPECT_EQ(
      refusal(Between(BenchRecord({AbruptFault(Component::kRa, 9.0, 3.0)}, 58, 6.0), 0.5, 5.0)),
      "stationarity");
  PlantParameters other;
  other.j_kg_m2 = 4e-6;
  EXPECT_EQ(refusal(Between(BenchRecord({}, 59, 6.0, other), 0.5, 5.0)), "tolerance");
}

// ---- detection

TEST(Detector, KeepsQuietForAQuarterOfAnHourAndSeesAFaultAfterIt) {
  RigParameters rig;
  rig.mc_nm = 0.33e-3;
  NoiseLevel noise;
  noise.w_rad_s = 0.5 * kRadPerSecondOfRpm;
  const auto record = BenchRecord({AbruptFault(Component::kRa, 6.0, 900.0)}, 61, 901.0);
  const auto healthy = Between(BenchRecord({}, 62, 8.0), 0.5, 8.0);
  const Result<Calibration> calibration = Calibrate(healthy, {});
  ASSERT_TRUE(calibration.ok());
  Detector detector(ParametersOf(calibration.value()),
                    NoiseOf(calibration.value()),
                    0.01,
                    7U,
                    calibration.value().thresholds,
                    calibration.value().samples,
                    NoiseScale(calibration.value().samples));
  const auto observations =
      MakeObservations(Between(record, 0.5, 901.0), Channels::kAll, 0.01, 10.0);
  std::optional<std::size_t> first;
  for (std::size_t k = 0; k < observations.size() && !first; ++k) {
    if (detector.Push(observations[k])) first = k;
  }
  ASSERT_TRUE(first.has_value());
  EXPECT_GE(*first, 89950U);
  EXPECT_LE(*first, 89955U);
}

// ---- the paper's methods

TEST(PaperMethods, JacobianHasTheCorrectedValuesOfEquation41) {
  const auto jacobian = FirstOrderJacobian(PlantParameters{});
  EXPECT_NEAR(jacobian[0][0], -6.4749e-3, 1e-6);
  EXPECT_NEAR(jacobian[1][3], 2393.5, 0.1);
  EXPECT_NEAR(jacobian[2][0], 2.1002e-3, 1e-6);
  EXPECT_NEAR(jacobian[2][5], 1.2639e4, 1.0);
}

PaperMethods AtFault(Component component, double value) {
  const PlantParameters nominal;
  PlantParameters faulty;
  faulty.Set(component, value);
  const ContinuousTheta theta = FirstOrderTheta(nominal);
  return RunPaperMethods(
      nominal, theta, FirstOrderTheta(faulty), {0.01 * theta[0], 0.03 * theta[1], 0.03 * theta[2]});
}

TEST(PaperMethods, SingleColumnGivesTables11And12) {
  // Paper Tables 11 and 12; they rest on exact parameters (see errata).
  const auto value = [](Component component, double fault) {
    return AtFault(component, fault)
        .single_column[static_cast<std::size_t>(Index(component))]
        .value;
  };
  EXPECT_NEAR(value(Component::kR1, 10.0), 9.8, 0.05);
  EXPECT_NEAR(value(Component::kR1, 56.0), 49.0, 0.5);
  EXPECT_NEAR(value(Component::kR1, 100.0), 79.0, 0.5);
  EXPECT_NEAR(value(Component::kR9, 33e3), 17e3, 100.0);
  EXPECT_NEAR(value(Component::kR9, 56e3), 18.2e3, 100.0);
  EXPECT_NEAR(value(Component::kR9, 100e3), 19e3, 100.0);
  EXPECT_NEAR(value(Component::kRa, 0.741), 0.62, 0.01);
  EXPECT_NEAR(value(Component::kB, 1.8e-4), 0.57e-4, 0.01e-4);
}

TEST(PaperMethods, ExactInversionHasNoLinearisationError) {
  for (const auto& [component, value] :
       std::vector<std::pair<Component, double>>{{Component::kR1, 100.0},
                                                 {Component::kR9, 33e3},
                                                 {Component::kR12, 2e3},
                                                 {Component::kC8, 10e-6},
                                                 {Component::kRa, 74.1},
                                                 {Component::kJ, 1.43e-4},
                                                 {Component::kB, 1.8e-4}}) {
    const PaperMethods methods = AtFault(component, value);
    const auto& exact = methods.exact[static_cast<std::size_t>(Index(component))];
    EXPECT_TRUE(exact.exists);
    EXPECT_NEAR(exact.value, value, 1e-4 * value) << Name(component);
  }
}

TEST(PaperMethods, FullJacobianHasRankThreeOfSeven) {
  const PaperMethods methods = AtFault(Component::kR1, 10.0);
  EXPECT_EQ(methods.full_jacobian_rank, 3);
  // What its pseudo-inverse says is spread over all parts: far from the ten ohms.
  EXPECT_GT(std::abs(methods.full_jacobian_values[0] - 10.0), 2.0);
}

TEST(PaperMethods, DecisionPathEndsAtEachOfThePapersFaults) {
  const std::vector<std::pair<Component, double>> faults = {{Component::kR1, 10.0},
                                                            {Component::kR1, 100.0},
                                                            {Component::kR9, 33e3},
                                                            {Component::kR12, 2e3},
                                                            {Component::kC8, 1e-6},
                                                            {Component::kC8, 47e-6},
                                                            {Component::kRa, 0.741},
                                                            {Component::kRa, 74.1},
                                                            {Component::kJ, 1.43e-4},
                                                            {Component::kJ, 1.43e-8},
                                                            {Component::kB, 1.8e-4},
                                                            {Component::kB, 1.8e-5}};
  for (const auto& [component, value] : faults) {
    const PaperMethods methods = AtFault(component, value);
    EXPECT_NE(std::find(methods.named.begin(), methods.named.end(), component), methods.named.end())
        << Name(component) << " = " << value;
    EXPECT_GE(methods.path.size(), 2U);
  }
  const PlantParameters nominal;
  const ContinuousTheta theta = FirstOrderTheta(nominal);
  EXPECT_TRUE(RunPaperMethods(nominal, theta, theta, {0.1, 0.1, 0.1}).named.empty());
}

}  // namespace
}  // namespace faultlab::core

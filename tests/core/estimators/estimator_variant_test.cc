#include "core/estimators/estimator_variant.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/estimators/estimator_bank.h"
#include "tests/core/estimators/records.h"

namespace faultlab::core {
namespace {

std::vector<Sample> MakeSamples(int count) {
  const testing::Record record =
      testing::MakeFirstOrder(testing::MakeBinary(count, 1, 1), 9.5e-3, 0.01, 1);
  std::vector<Sample> samples;
  for (std::size_t k = 0; k < record.u.size(); ++k) {
    Sample& sample = samples.emplace_back();
    sample.index = static_cast<std::int64_t>(k);
    sample.t_s = 0.01 * static_cast<double>(k);
    sample.uc_v = record.u[k];
    sample.um_v = record.y[k];
  }
  return samples;
}

VariantSpec SwaSpec(int window) {
  VariantSpec spec;
  spec.window_samples = window;
  return spec;
}

VariantSpec SiaSpec(int window, int integral) {
  VariantSpec spec;
  spec.method = EstimatorMethod::kSia;
  spec.window_samples = window;
  spec.integral_samples = integral;
  return spec;
}

TEST(EstimatorVariant, EqualsTheBankForTheSixStandardShapes) {
  std::vector<VariantSpec> specs;
  for (const EstimatorShape& shape : kEstimatorShapes) {
    specs.push_back(shape.integral_samples == 0
                        ? SwaSpec(shape.window_samples)
                        : SiaSpec(shape.window_samples, shape.integral_samples));
  }
  const std::vector<Sample> samples = MakeSamples(700);
  const auto study = RunStudy(specs, samples);
  ASSERT_TRUE(study.ok());
  EstimatorBank bank({.sia_mode = SiaMode::kPaper});
  std::array<Estimate<3>, kEstimatorCount> answer;
  for (const Sample& sample : samples) {
    bank.Push(sample, answer);
  }
  for (std::size_t i = 0; i < specs.size(); ++i) {
    EXPECT_EQ(Name(specs[i]), kEstimatorShapes[i].name);
    ASSERT_EQ(study.value()[i].size(), samples.size());
    for (std::size_t j = 0; j < 3; ++j) {
      EXPECT_EQ(study.value()[i].back().theta[j], answer[i].theta[j]);
    }
    EXPECT_TRUE(std::isnan(study.value()[i].back().theta[3]));
  }
}

TEST(EstimatorVariant, RunsEveryCombinationThatItOffers) {
  const std::vector<Sample> samples = MakeSamples(800);
  int ran = 0;
  for (EstimatorMethod method : {EstimatorMethod::kSwa, EstimatorMethod::kSia}) {
    for (int order = 1; order <= kOrderMax; ++order) {
      for (bool affine : {false, true}) {
        for (bool instrumental : {false, true}) {
          for (double noise : {0.0, 0.01}) {
            for (SiaMode mode : {SiaMode::kPaper, SiaMode::kExact}) {
              VariantSpec spec = method == EstimatorMethod::kSwa ? SwaSpec(300) : SiaSpec(300, 20);
              spec.order = order;
              spec.affine = affine;
              spec.instrumental = instrumental;
              spec.noise_sigma_v = noise;
              spec.sia_mode = mode;
              spec.delta_s = 9.5e-3;
              const std::array<VariantSpec, 1> specs = {spec};
              const auto study = RunStudy(specs, samples);
              if (!study.ok()) {
                EXPECT_FALSE(study.error().field.empty());
                continue;
              }
              ++ran;
              const VariantEstimate& last = study.value()[0].back();
              EXPECT_NE(last.status, EstimateStatus::kInvalid) << Name(spec);
              EXPECT_FALSE(Name(spec).empty());
              const auto used = ParameterNames(spec).size();
              for (std::size_t j = 0; j < used; ++j) {
                // A high order and the noise subtracted may leave nothing to solve.
                const bool none =
                    order > 2 && noise > 0.0 && last.status == EstimateStatus::kNotExcited;
                EXPECT_TRUE(none || std::isfinite(last.theta[j])) << Name(spec) << " " << j;
              }
            }
          }
        }
      }
    }
  }
  EXPECT_EQ(ran, 8 + 2 + 12 + 2 * 8) << "of orders 1, 2 and of those above";
}

TEST(EstimatorVariant, NamesTheFieldThatItRefuses) {
  const auto refused_field = [](VariantSpec spec) {
    const auto made = MakeVariant(spec);
    return made.ok() ? std::string("accepted") : made.error().field;
  };
  EXPECT_EQ(refused_field(SwaSpec(100)), "accepted");
  EXPECT_EQ(refused_field(SwaSpec(5)), "window_samples");
  EXPECT_EQ(refused_field(SwaSpec(kWindowMax + 1)), "window_samples");
  EXPECT_EQ(refused_field(SiaSpec(20, 20)), "integral_samples");
  EXPECT_EQ(refused_field(SiaSpec(20, 0)), "integral_samples");
  VariantSpec spec = SwaSpec(100);
  spec.order = kOrderMax + 1;
  EXPECT_EQ(refused_field(spec), "order");
  spec = SwaSpec(100);
  spec.sia_mode = SiaMode::kExact;
  EXPECT_EQ(refused_field(spec), "sia_mode");
  spec = SiaSpec(100, 20);
  spec.instrumental = true;
  EXPECT_EQ(refused_field(spec), "instrumental");
  spec = SwaSpec(100);
  spec.noise_sigma_v = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(refused_field(spec), "noise_sigma_v");
  spec = SiaSpec(100, 20);
  spec.delta_s = 0.02;
  EXPECT_EQ(refused_field(spec), "delta_s");
  const std::array<VariantSpec, 2> specs = {SwaSpec(100), SwaSpec(1)};
  EXPECT_EQ(RunStudy(specs, {}).error().field, "1/window_samples");
}

TEST(EstimatorVariant, NamesItsParametersByMethodAndOrder) {
  VariantSpec spec = SwaSpec(100);
  spec.order = 2;
  spec.affine = true;
  EXPECT_EQ(ParameterNames(spec),
            (std::vector<std::string>{"b0d", "b1d", "b2d", "a1d", "a2d", "offset"}));
  EXPECT_EQ(Name(spec), "swa_100_o2_affine");
  spec = SiaSpec(500, 20);
  spec.sia_mode = SiaMode::kExact;
  EXPECT_EQ(ParameterNames(spec), (std::vector<std::string>{"b0", "b1", "a1"}));
  EXPECT_EQ(Name(spec), "sia_500_20_exact");
}

}  // namespace
}  // namespace faultlab::core

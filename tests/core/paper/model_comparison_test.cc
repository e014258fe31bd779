#include "core/paper/model_comparison.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/plant/simulate_record.h"
#include "core/signals/prbs.h"
#include "tests/paper_bench.h"

namespace faultlab::core {
namespace {

// A rig whose output is read at the edge of its input (delta of 10 us, after the amplifier has
// settled), without noise and friction: then the paper's models are exact except for the
// inductance.
std::vector<Sample> IdealRecord(PlantParameters plant) {
  plant.la_henry = 1e-9;
  BenchProfile profile = paper::CircuitSimulation();
  profile.noise = {};
  profile.delta_s = 1e-5;
  return SimulateRecord(profile, plant, MakePrbs({}, 600, 0.01), {}, 1, paper::kPeriodS);
}

ModelsToCompare TrueModels(const PlantParameters& plant) {
  ModelsToCompare models;
  models.plant = plant;
  models.sia = MakeContinuous(plant);
  models.swa = Discretise(models.sia, 0.01, 0.0);
  return models;
}

TEST(CompareModels, NamesTheFiveModelsOfThePaperInOrder) {
  const PlantParameters plant = paper::Plant();
  const std::vector<Sample> record = IdealRecord(plant);
  std::vector<std::string> names;
  for (const ComparedFit& compared : CompareModels(TrueModels(plant), record, paper::kPeriodS)) {
    names.push_back(compared.name);
    EXPECT_EQ(compared.fit.simulated.size(), record.size());
  }
  EXPECT_EQ(names, (std::vector<std::string>{"swa", "sia", "mc_0", "mc_0.48mNm", "mc_0.33mNm"}));
}

TEST(CompareModels, TrueModelsOfAFrictionlessRigFitAndAgree) {
  PlantParameters plant = paper::Plant();
  plant.series_ohm = 56.0;
  const std::vector<Sample> record = IdealRecord(plant);
  const auto fits =
      CompareModels(TrueModels(plant), std::span(record).subspan(50), paper::kPeriodS);
  EXPECT_GT(fits[0].fit.fit_percent, 99.9);
  EXPECT_NEAR(fits[1].fit.fit_percent, fits[0].fit.fit_percent, 1e-6);
  EXPECT_NEAR(fits[2].fit.fit_percent, fits[0].fit.fit_percent, 0.05);
  EXPECT_LT(fits[4].fit.fit_percent, 0.0);  // the rig has no such friction
  EXPECT_LT(fits[3].fit.fit_percent, fits[4].fit.fit_percent);
}

TEST(CompareModels, AnImpossibleEstimateHasNoFitAndTheOthersStay) {
  const PlantParameters plant = paper::Plant();
  const std::vector<Sample> record = IdealRecord(plant);
  ModelsToCompare models = TrueModels(plant);
  models.sia.a1 = -0.01;
  const auto fits = CompareModels(models, record, paper::kPeriodS);
  EXPECT_TRUE(std::isnan(fits[1].fit.fit_percent));
  EXPECT_GT(fits[0].fit.fit_percent, 90.0);
}

}  // namespace
}  // namespace faultlab::core

#include "core/types/plant_parameters.h"

#include <gtest/gtest.h>

#include "core/types/check.h"
#include "tests/paper_bench.h"

namespace faultlab::core {
namespace {

TEST(PlantParameters, NominalGainIsTwelveFifths) {
  EXPECT_DOUBLE_EQ(paper::Plant().gain(), 12.0 / 5.0);  // paper section 2.1.2
}

TEST(PlantParameters, SetChangesOneComponentAlone) {
  for (const Component changed : paper::Parts()) {
    PlantParameters parameters = paper::Plant();
    parameters.Set(changed, 2.0 * parameters.Get(changed));
    for (const Component component : paper::Parts()) {
      const double factor = component == changed ? 2.0 : 1.0;
      EXPECT_DOUBLE_EQ(parameters.Get(component), factor * paper::Plant().Get(component))
          << Name(changed) << " " << Name(component);
    }
  }
}

TEST(PlantParameters, RefusesWhatIsNotPositive) {
  PlantParameters parameters = paper::Plant();
  EXPECT_THROW(parameters.Set(paper::kJ, 0.0), ContractError);
  EXPECT_THROW(parameters.Set(paper::kJ, -1.0), ContractError);
}

}  // namespace
}  // namespace faultlab::core

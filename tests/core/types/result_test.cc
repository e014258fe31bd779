#include "core/types/result.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace faultlab::core {
namespace {

TEST(Result, ValueOfAnErrorIsABugThatNamesTheError) {
  const Result<int> result = Error{ErrorCode::kBusy, "try again later", ""};
  EXPECT_FALSE(result.ok());
  try {
    static_cast<void>(result.value());
    FAIL() << "value() of an error did not throw";
  } catch (const ContractError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("try again later"));
  }
}

TEST(Result, ErrorOfAValueIsABug) {
  const Result<int> result = 7;
  EXPECT_EQ(result.value(), 7);
  EXPECT_THROW(static_cast<void>(result.error()), ContractError);
}

TEST(Check, SaysConditionPlaceAndValues) {
  try {
    const int samples = -3;
    LAB_CHECK(samples >= 0, samples, "of R1");
    FAIL() << "LAB_CHECK did not throw";
  } catch (const ContractError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("samples >= 0 -3 of R1"));
    EXPECT_THAT(error.what(), testing::HasSubstr("result_test.cc"));
  }
}

}  // namespace
}  // namespace faultlab::core

#include "core/types/number_text.h"

#include <gtest/gtest.h>

namespace faultlab::core {
namespace {

TEST(ParseValue, ReadsValuesAsPeopleWriteThoseOfParts) {
  const std::pair<const char*, double> kTexts[] = {{"33k", 33e3},
                                                   {"5.6k", 5600.0},
                                                   {"4k7", 4700.0},
                                                   {"4R7", 4.7},
                                                   {"10u", 10e-6},
                                                   {"0.1\u00b5F", 0.1e-6},
                                                   {"47 pF", 47e-12},
                                                   {"33 kohm", 33e3},
                                                   {"100\u2126", 100.0},
                                                   {"1.43e-5", 1.43e-5},
                                                   {"-2", -2.0}};
  for (const auto& [text, value] : kTexts) {
    ASSERT_TRUE(ParseValue(text)) << text;
    EXPECT_NEAR(*ParseValue(text) / value, 1.0, 1e-12) << text;
  }
}

TEST(ParseValue, RefusesTheRest) {
  for (const char* text : {"", "k", "k7", "4.7k7", "4k7k", "3x", "1e", "nan", "inf", "ohm", "F"}) {
    EXPECT_FALSE(ParseValue(text)) << text;
  }
}

TEST(Format, WritesAsPrintfHoweverLong) {
  EXPECT_EQ(Format("%s %.3g %d%%", "R1", 0.12345, 7), "R1 0.123 7%");
  EXPECT_EQ(Format("%s", std::string(5000, 'x').c_str()), std::string(5000, 'x'));
  EXPECT_EQ(Format("%s", ""), "");
  EXPECT_EQ(Shortest(0.1), "0.1");
}

}  // namespace
}  // namespace faultlab::core

#include "server/diagnosis_json/channel_ranges.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "hardware/bench/benches.h"

namespace faultlab::server {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// A record of the paper's bench whose readings are multiplied.
std::vector<core::Sample> Record(double uc_factor, double um_factor, double n_factor = 1.0) {
  std::vector<core::Sample> samples;
  for (int k = 0; k < 1000; ++k) {
    core::Sample sample;
    sample.index = k;
    sample.t_s = 0.01 * k;
    sample.uc_v = uc_factor * (k % 2 == 0 ? 2.0 : 3.0);
    sample.um_v = um_factor * (k % 2 == 0 ? 4.8 : 7.1);
    sample.n_rpm = n_factor * 500.0;
    samples.push_back(sample);
  }
  return samples;
}

core::Result<std::vector<std::string>> NotesOf(const std::vector<core::Sample>& samples) {
  return NotesOnRanges(samples, hardware::PaperBench(), "a.csv");
}

TEST(ChannelRanges, SayNothingOfARecordOfTheBench) {
  EXPECT_THAT(NotesOf(Record(1.0, 1.0)).value(), IsEmpty());
  EXPECT_THAT(NotesOf({}).value(), IsEmpty());
  std::vector<core::Sample> impulses = Record(1.0, 1.0);
  for (int k = 0; k < 40; ++k) impulses[25 * static_cast<std::size_t>(k)].um_v = 1e6;
  EXPECT_THAT(NotesOf(impulses).value(), IsEmpty()) << "some wild readings are no other unit";
}

TEST(ChannelRanges, NameTheUnitThatWouldFit) {
  const auto millivolts = NotesOf(Record(1000.0, 1.0));
  ASSERT_FALSE(millivolts.ok());
  EXPECT_EQ(millivolts.error().field, "uc_v");
  EXPECT_EQ(millivolts.error().reason, "value_beyond_range");
  EXPECT_THAT(millivolts.error().message, HasSubstr("a.csv: uc_v of 3000 V is beyond"));
  EXPECT_THAT(millivolts.error().message, HasSubstr(": is the unit mV?"));
  const auto speed = NotesOf(Record(1.0, 25.0));
  ASSERT_FALSE(speed.ok());
  EXPECT_THAT(speed.error().message, HasSubstr("is it another quantity, or of another bench?"));
}

TEST(ChannelRanges, NoteWhatIsALittleBeyond) {
  EXPECT_THAT(NotesOf(Record(1.0, 2.5)).value(),
              ElementsAre(HasSubstr("um_v of 17.75 V is beyond -10 to 10 V of the bench")));
}

}  // namespace
}  // namespace faultlab::server

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <random>

#include "server/csv/csv_record.h"
#include "server/csv/csv_writer.h"

namespace faultlab::server {
namespace {

std::uint64_t Bits(double value) {
  return std::bit_cast<std::uint64_t>(value);
}

TEST(CsvWriter, WritesNumbersThatReadBackToTheSameBits) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  std::vector<core::Sample> samples(500);
  for (std::size_t k = 0; k < samples.size(); ++k) {
    samples[k].index = static_cast<std::int64_t>(k);
    samples[k].t_s = 0.01 * static_cast<double>(k);
    samples[k].uc_v = k % 2 == 0 ? 2.0 : 3.0;
    samples[k].um_v = normal(random);
    samples[k].ia_a = k % 10 == 4 ? core::kAbsent : 1e-9 * normal(random);
    samples[k].n_rpm = 1e5 * normal(random);
    samples[k].delta_s = k == 3 ? core::kAbsent : 9.5e-3 + 1e-5 * normal(random);
  }
  const core::Result<CsvRecord> read = ParseCsv(FormatCsv(samples), "written");
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read.value().samples.size(), samples.size());
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const core::Sample& back = read.value().samples[k];
    EXPECT_EQ(back.index, samples[k].index);
    EXPECT_EQ(Bits(back.t_s), Bits(samples[k].t_s));
    EXPECT_EQ(Bits(back.um_v), Bits(samples[k].um_v));
    EXPECT_EQ(Bits(back.ia_a), Bits(samples[k].ia_a));
    EXPECT_EQ(Bits(back.n_rpm), Bits(samples[k].n_rpm));
    EXPECT_EQ(Bits(back.delta_s), Bits(samples[k].delta_s));
  }
}

TEST(CsvWriter, LeavesOutChannelsThatHoldNoNumber) {
  std::vector<core::Sample> samples(2);
  samples[0].um_v = 1.5;
  samples[1].t_s = 0.01;
  samples[1].ua_v = 2.0;
  EXPECT_EQ(FormatCsv(samples), "t_s,uc_v,um_v,ua_v\n0,0,1.5,\n0.01,0,,2\n");
}

TEST(CsvWriter, KeepsCommentsOnOneLine) {
  EXPECT_EQ(FormatCsv({}, {{"fault R1\n= 100"}}), "# fault R1 = 100\nt_s,uc_v,um_v\n");
}

}  // namespace
}  // namespace faultlab::server

#include "server/storage/chunk_codec.h"

#include <gmock/gmock.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

#include "core/types/check.h"

namespace faultlab::server {
namespace {

std::vector<core::Sample> BenchLike(int count, std::int64_t first) {
  std::mt19937_64 random(7);
  std::vector<core::Sample> samples;
  for (int i = 0; i < count; ++i) {
    core::Sample s;
    s.index = first + i;
    s.t_s = static_cast<double>(s.index) * 0.01;
    s.uc_v = (random() & 1) != 0 ? 2.0 : 3.0;
    s.um_v = std::ldexp(static_cast<double>(random() % 65536), -12);
    s.ia_a = std::ldexp(static_cast<double>(random() % 65536), -18);
    s.n_rpm = static_cast<double>(random() % 3000) / 7.0;
    samples.push_back(s);
  }
  return samples;
}

void ExpectBitEqual(const std::vector<core::Sample>& a, const std::vector<core::Sample>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(a[i].index, b[i].index) << i;
    for (const auto member : {&core::Sample::t_s,
                              &core::Sample::uc_v,
                              &core::Sample::um_v,
                              &core::Sample::ua_v,
                              &core::Sample::ia_a,
                              &core::Sample::n_rpm,
                              &core::Sample::delta_s}) {
      ASSERT_EQ(std::bit_cast<std::uint64_t>(a[i].*member),
                std::bit_cast<std::uint64_t>(b[i].*member))
          << i;
    }
  }
}

TEST(ChunkCodec, GivesBackEveryBitOfABenchRecording) {
  const auto samples = BenchLike(100, 12300);
  const auto decoded = DecodeChunk(EncodeChunk(samples));
  ASSERT_TRUE(decoded.ok()) << decoded.error().message;
  ExpectBitEqual(samples, decoded.value());
}

TEST(ChunkCodec, GivesBackNanPayloadsSignedZerosAndInfinities) {
  auto samples = BenchLike(5, 0);
  samples[0].um_v = std::bit_cast<double>(std::uint64_t{0x7ff8000000001234});
  samples[1].um_v = -0.0;
  samples[2].um_v = std::numeric_limits<double>::infinity();
  samples[3].um_v = std::numeric_limits<double>::denorm_min();
  samples[4].t_s = -1.0;
  const auto decoded = DecodeChunk(EncodeChunk(samples));
  ASSERT_TRUE(decoded.ok());
  ExpectBitEqual(samples, decoded.value());
}

TEST(ChunkCodec, GivesBackIndexesWithGapsAndTimesWithJitter) {
  auto samples = BenchLike(50, 1);
  for (std::size_t i = 20; i < samples.size(); ++i) samples[i].index += 17;
  for (auto& s : samples) s.t_s += 1e-4 * std::sin(static_cast<double>(s.index));
  const auto decoded = DecodeChunk(EncodeChunk(samples));
  ASSERT_TRUE(decoded.ok());
  ExpectBitEqual(samples, decoded.value());
}

TEST(ChunkCodec, KeepsTheMeasuredDeltaInAColumnOfItsOwn) {
  auto samples = BenchLike(50, 1);
  const std::size_t without = EncodeChunk(samples).size();
  for (std::size_t i = 1; i < samples.size(); ++i) {
    samples[i].delta_s = 9.5e-3 + 1e-6 * static_cast<double>(i);
  }
  const Bytes chunk = EncodeChunk(samples);
  EXPECT_EQ(std::to_integer<int>(chunk[6]), 8);  // columns
  EXPECT_LE(chunk.size(), without + 1 + 50 * sizeof(double));
  const auto decoded = DecodeChunk(chunk);
  ASSERT_TRUE(decoded.ok());
  ExpectBitEqual(samples, decoded.value());
}

/// As servers wrote it before samples had a delta: one sample, index 7, t 0.07 s, uc 2 V.
TEST(ChunkCodec, ReadsAChunkOfSevenColumns) {
  std::vector<core::Sample> samples(1);
  samples[0].index = 7;
  samples[0].t_s = 0.07;
  samples[0].uc_v = 2.0;
  const Bytes chunk = EncodeChunk(samples);
  EXPECT_EQ(std::to_integer<int>(chunk[6]), 7);
  const auto decoded = DecodeChunk(chunk);
  ASSERT_TRUE(decoded.ok());
  EXPECT_TRUE(std::isnan(decoded.value()[0].delta_s));
}

TEST(ChunkCodec, GivesBackARandomRecordOfAnyLength) {
  std::mt19937_64 random(11);
  for (int count : {1, 2, 3, 255, 256, 257, 1000}) {
    auto samples = BenchLike(count, -5);
    for (auto& s : samples) s.ua_v = std::bit_cast<double>(random());
    const auto decoded = DecodeChunk(EncodeChunk(samples));
    ASSERT_TRUE(decoded.ok());
    ExpectBitEqual(samples, decoded.value());
  }
}

TEST(ChunkCodec, IsShorterThanHalfOfTheRawSamplesForABench) {
  const auto samples = BenchLike(100, 0);
  EXPECT_LT(EncodeChunk(samples).size() * 2, samples.size() * 7 * sizeof(double));
}

TEST(ChunkCodec, RefusesEveryChangedByteAndEveryCut) {
  const Bytes good = EncodeChunk(BenchLike(20, 3));
  for (std::size_t i = 0; i < good.size(); ++i) {
    Bytes bad = good;
    bad[i] ^= std::byte{0x40};
    EXPECT_FALSE(DecodeChunk(bad).ok()) << "byte " << i;
  }
  for (std::size_t size = 0; size < good.size(); ++size) {
    EXPECT_FALSE(DecodeChunk({good.data(), size}).ok()) << "cut to " << size;
  }
  const auto error = DecodeChunk({good.data(), 10}).error();
  EXPECT_EQ(error.code, core::ErrorCode::kUnavailable);
  EXPECT_THAT(error.message, testing::HasSubstr("damaged"));
}

TEST(ChunkCodec, TakesAnEmptyChunkForABug) {
  EXPECT_THROW((void)EncodeChunk({}), core::ContractError);
}

}  // namespace
}  // namespace faultlab::server

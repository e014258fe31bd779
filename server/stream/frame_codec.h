#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "core/types/frame.h"

namespace faultlab::server {

inline constexpr int kSignalCount = 5;  ///< uc, um, ua, ia, n
inline constexpr int kChannelCount = kSignalCount + 3 * core::kEstimatorCount;
inline constexpr int kStatusBytes = 8;  ///< one per estimator, two of padding
inline constexpr std::size_t kFrameHeaderBytes = 16;
inline constexpr std::size_t kRowBytes = kChannelCount * sizeof(float) + kStatusBytes;

/// "uc_v", "um_v", .., "sia_500_20.a1": the columns of a row, in order.
const std::array<std::string, kChannelCount>& ChannelNames();

/// One sample with its estimates, as it is transmitted. NaN = absent or not available.
struct StreamRow {
  std::array<float, kChannelCount> values;
  std::array<std::uint8_t, kStatusBytes> statuses;
};

StreamRow MakeRow(const core::Frame& frame);

/// The binary message of the contract, little endian:
///   u8 version = 1, u8 type = 1, u16 n, u32 first_index, f64 t_server_s, n x 23 f32, n x 8 u8
/// @param rows  consecutive samples, at most 65535, the first one has index `first_index`
std::string EncodeFrameMessage(std::span<const StreamRow> rows,
                               std::int64_t first_index,
                               double t_server_s);

}  // namespace faultlab::server

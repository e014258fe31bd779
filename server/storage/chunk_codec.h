#pragma once

#include <span>
#include <vector>

#include "core/types/result.h"
#include "core/types/sample.h"
#include "server/storage/blob_store.h"

namespace faultlab::server {

/// The reason of what cannot be read any more.
inline constexpr const char* kRecordingDamaged = "recording_damaged";

inline constexpr int kChunkSamplesMax = 1 << 20;

/// Samples as bytes, little endian, bit-exact (NaN payloads and signed zeros included):
///   u32 magic "FLCH", u16 version = 1, u16 columns = 7 or 8, u32 samples n, u32 CRC-32 of all that
///   follows, then the columns index, t_s, uc_v, um_v, ua_v, ia_a, n_rpm and, in chunks of 8
///   columns, delta_s (else NaN), each a u8 mode and
///     0 raw        n x 8 bytes
///     1 constant   8 bytes
///     2 dictionary u8 k-1, k x 8 bytes, n x u8     (k <= 256 distinct values and shorter than raw)
///     3 run        (index only) i64 first, the others follow by +1
///     4 clock      (t_s only) f64 period; t = index * period, bit for bit
/// Contract of Encode: 1 <= samples.size() <= kChunkSamplesMax.
Bytes EncodeChunk(std::span<const core::Sample> samples);

/// Refuses a wrong magic, version, length or checksum with kUnavailable: the recording is damaged.
core::Result<std::vector<core::Sample>> DecodeChunk(std::span<const std::byte> bytes);

}  // namespace faultlab::server

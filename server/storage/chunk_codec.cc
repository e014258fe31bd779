#include "server/storage/chunk_codec.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "core/types/check.h"

namespace faultlab::server {
namespace {

static_assert(std::endian::native == std::endian::little, "add byte swaps for this machine");

constexpr std::uint32_t kMagic = 0x48434C46;  // "FLCH"
constexpr std::uint16_t kVersion = 1;
constexpr std::uint16_t kColumnsMax = 8;
constexpr std::uint16_t kColumnsWithoutDelta = 7;
constexpr std::size_t kHeaderBytes = 16;
constexpr std::size_t kDictionaryMax = 256;

enum Mode : std::uint8_t { kRaw = 0, kConstant = 1, kDictionary = 2, kRunOfIndex = 3, kClock = 4 };

using Column = std::vector<std::uint64_t>;  // bit patterns: NaN and -0 stay exact

constexpr std::array<std::uint32_t, 256> MakeCrcTable() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t i = 0; i < table.size(); ++i) {
    std::uint32_t remainder = i;
    for (int bit = 0; bit < 8; ++bit) {
      remainder = (remainder & 1) != 0 ? 0xEDB88320u ^ (remainder >> 1) : remainder >> 1;
    }
    table[i] = remainder;
  }
  return table;
}
constexpr std::array<std::uint32_t, 256> kCrcTable = MakeCrcTable();

std::uint32_t Crc32(std::span<const std::byte> bytes) {
  std::uint32_t crc = 0xFFFFFFFFu;
  for (const std::byte byte : bytes) {
    crc = kCrcTable[(crc ^ static_cast<std::uint32_t>(byte)) & 0xFFu] ^ (crc >> 8);
  }
  return ~crc;
}

template <typename T>
void Append(Bytes& out, T value) {
  const auto* data = reinterpret_cast<const std::byte*>(&value);
  out.insert(out.end(), data, data + sizeof(T));
}

template <typename T>
bool Take(std::span<const std::byte>& in, T& value) {
  if (in.size() < sizeof(T)) return false;
  std::memcpy(&value, in.data(), sizeof(T));
  in = in.subspan(sizeof(T));
  return true;
}

using Columns = std::array<Column, kColumnsMax>;

Columns ToColumns(std::span<const core::Sample> samples) {
  Columns columns;
  for (auto& column : columns) column.reserve(samples.size());
  for (const auto& s : samples) {
    columns[0].push_back(static_cast<std::uint64_t>(s.index));
    const std::array<double, 7> values = {
        s.t_s, s.uc_v, s.um_v, s.ua_v, s.ia_a, s.n_rpm, s.delta_s};
    for (std::size_t i = 0; i < values.size(); ++i) {
      columns[i + 1].push_back(std::bit_cast<std::uint64_t>(values[i]));
    }
  }
  return columns;
}

bool RisesByOne(const Column& column) {
  for (std::size_t i = 1; i < column.size(); ++i) {
    if (column[i] != column[i - 1] + 1) return false;
  }
  return true;
}

double ClockTime(std::uint64_t index, double period_s) {
  return static_cast<double>(static_cast<std::int64_t>(index)) * period_s;
}

/// The period for which every t is index * period, bit for bit; 0 if there is none.
double ClockPeriod(const Column& index, const Column& time) {
  const auto last = static_cast<double>(static_cast<std::int64_t>(index.back()));
  if (last == 0.0) return 0.0;
  const double guess = std::bit_cast<double>(time.back()) / last;
  const auto fits = [&](double period) {
    for (std::size_t i = 0; i < index.size(); ++i) {
      if (std::bit_cast<std::uint64_t>(ClockTime(index[i], period)) != time[i]) return false;
    }
    return true;
  };
  // t / index may have a rounding error: the usual periods are tried first, exactly as written.
  for (const double period : {0.01, 0.001, 0.005, 0.02, 0.002, 0.05, 0.1, guess}) {
    if (fits(period)) return period;
  }
  return 0.0;
}

bool AppendDictionary(Bytes& out, const Column& column) {
  Column words = column;
  std::ranges::sort(words);
  words.erase(std::unique(words.begin(), words.end()), words.end());
  const bool shorter = 1 + 8 * words.size() + column.size() < 8 * column.size();
  if (words.size() > kDictionaryMax || !shorter) return false;
  Append(out, kDictionary);
  Append(out, static_cast<std::uint8_t>(words.size() - 1));
  for (const std::uint64_t word : words) Append(out, word);
  for (const std::uint64_t value : column) {
    const auto at = std::lower_bound(words.begin(), words.end(), value) - words.begin();
    Append(out, static_cast<std::uint8_t>(at));
  }
  return true;
}

void AppendColumn(Bytes& out, const Column& column) {
  const bool constant =
      std::ranges::all_of(column, [&](std::uint64_t value) { return value == column.front(); });
  if (constant) {
    Append(out, kConstant);
    Append(out, column.front());
    return;
  }
  if (AppendDictionary(out, column)) return;
  Append(out, kRaw);
  for (const std::uint64_t value : column) Append(out, value);
}

bool TakeDictionary(std::span<const std::byte>& in, Column& column) {
  std::uint8_t last = 0;
  if (!Take(in, last)) return false;
  Column words(std::size_t{last} + 1);
  for (auto& word : words) {
    if (!Take(in, word)) return false;
  }
  for (auto& value : column) {
    std::uint8_t at = 0;
    if (!Take(in, at) || at >= words.size()) return false;
    value = words[at];
  }
  return true;
}

bool TakeColumn(std::span<const std::byte>& in, const Column& index, Column& column) {
  Mode mode{};
  std::uint64_t first = 0;
  if (!Take(in, mode)) return false;
  switch (mode) {
    case kRaw:
      return std::ranges::all_of(column, [&](std::uint64_t& value) { return Take(in, value); });
    case kConstant:
      if (!Take(in, first)) return false;
      std::ranges::fill(column, first);
      return true;
    case kDictionary:
      return TakeDictionary(in, column);
    case kRunOfIndex:
      if (!Take(in, first)) return false;
      for (auto& value : column) value = first++;
      return true;
    case kClock:
      if (!Take(in, first)) return false;
      for (std::size_t i = 0; i < column.size(); ++i) {
        column[i] = std::bit_cast<std::uint64_t>(ClockTime(index[i], std::bit_cast<double>(first)));
      }
      return true;
  }
  return false;
}

core::Error Damaged(const char* what) {
  return {core::ErrorCode::kUnavailable,
          std::string("a chunk of this recording is damaged (") + what +
              "); restore the database from a backup",
          "",
          kRecordingDamaged};
}

core::Sample ToSample(const Columns& columns, std::size_t count, std::size_t i) {
  core::Sample s;
  s.index = static_cast<std::int64_t>(columns[0][i]);
  const std::array<double*, 7> fields = {
      &s.t_s, &s.uc_v, &s.um_v, &s.ua_v, &s.ia_a, &s.n_rpm, &s.delta_s};
  for (std::size_t c = 1; c < count; ++c) *fields[c - 1] = std::bit_cast<double>(columns[c][i]);
  return s;
}

}  // namespace

Bytes EncodeChunk(std::span<const core::Sample> samples) {
  LAB_CHECK(!samples.empty() && samples.size() <= kChunkSamplesMax, samples.size());
  const auto columns = ToColumns(samples);
  const bool has_delta =
      std::ranges::any_of(samples, [](const auto& s) { return !std::isnan(s.delta_s); });
  const std::uint16_t count = has_delta ? kColumnsMax : kColumnsWithoutDelta;
  Bytes body;
  if (RisesByOne(columns[0])) {
    Append(body, kRunOfIndex);
    Append(body, columns[0].front());
  } else {
    AppendColumn(body, columns[0]);
  }
  const double period_s = ClockPeriod(columns[0], columns[1]);
  if (period_s != 0.0) {
    Append(body, kClock);
    Append(body, period_s);
  } else {
    AppendColumn(body, columns[1]);
  }
  for (std::size_t c = 2; c < count; ++c) AppendColumn(body, columns[c]);

  Bytes out;
  out.reserve(kHeaderBytes + body.size());
  Append(out, kMagic);
  Append(out, kVersion);
  Append(out, count);
  Append(out, static_cast<std::uint32_t>(samples.size()));
  Append(out, Crc32(body));
  out.insert(out.end(), body.begin(), body.end());
  return out;
}

core::Result<std::vector<core::Sample>> DecodeChunk(std::span<const std::byte> bytes) {
  std::uint32_t magic = 0;
  std::uint16_t version = 0;
  std::uint16_t column_count = 0;
  std::uint32_t samples = 0;
  std::uint32_t checksum = 0;
  if (!Take(bytes, magic) || !Take(bytes, version) || !Take(bytes, column_count) ||
      !Take(bytes, samples) || !Take(bytes, checksum)) {
    return Damaged("too short");
  }
  if (magic != kMagic) return Damaged("wrong magic");
  const bool known = column_count == kColumnsMax || column_count == kColumnsWithoutDelta;
  if (version != kVersion || !known) return Damaged("unknown version");
  if (samples == 0 || samples > kChunkSamplesMax) return Damaged("impossible length");
  if (Crc32(bytes) != checksum) return Damaged("wrong checksum");

  Columns columns;
  for (std::size_t c = 0; c < column_count; ++c) {
    columns[c].resize(samples);
    if (!TakeColumn(bytes, columns[0], columns[c])) return Damaged("short column");
  }
  if (!bytes.empty()) return Damaged("bytes left over");
  std::vector<core::Sample> out;
  out.reserve(samples);
  for (std::size_t i = 0; i < samples; ++i) {
    out.push_back(ToSample(columns, column_count, i));
  }
  return out;
}

}  // namespace faultlab::server

#include "server/stream/frame_codec.h"

#include <bit>
#include <cstring>

#include "core/types/check.h"

namespace faultlab::server {
namespace {

static_assert(std::endian::native == std::endian::little,
              "rows are copied to the wire as they lie in memory");
static_assert(sizeof(StreamRow) == kRowBytes);

constexpr std::uint8_t kVersion = 1;
constexpr std::uint8_t kTypeFrames = 1;

template <typename T>
char* Put(char* out, T value) {
  std::memcpy(out, &value, sizeof value);
  return out + sizeof value;
}

}  // namespace

const std::array<std::string, kChannelCount>& ChannelNames() {
  static const auto names = [] {
    std::array<std::string, kChannelCount> out;
    std::size_t next = 0;
    for (const char* signal : {"uc_v", "um_v", "ua_v", "ia_a", "n_rpm"}) out[next++] = signal;
    for (const core::EstimatorShape& shape : core::kEstimatorShapes) {
      const char* suffix = shape.integral_samples == 0 ? "d" : "";
      for (const char* parameter : {"b0", "b1", "a1"}) {
        out[next++] = std::string(shape.name) + "." + parameter + suffix;
      }
    }
    return out;
  }();
  return names;
}

StreamRow MakeRow(const core::Frame& frame) {
  StreamRow row{};
  const core::Sample& sample = frame.sample;
  std::size_t next = 0;
  for (const double value : {sample.uc_v, sample.um_v, sample.ua_v, sample.ia_a, sample.n_rpm}) {
    row.values[next++] = static_cast<float>(value);
  }
  for (std::size_t i = 0; i < frame.estimates.size(); ++i) {
    const core::Estimate<3> estimate = core::Shown(frame.estimates[i]);
    for (const double theta : estimate.theta) row.values[next++] = static_cast<float>(theta);
    row.statuses[i] = static_cast<std::uint8_t>(estimate.status);
  }
  return row;
}

std::string EncodeFrameMessage(std::span<const StreamRow> rows,
                               std::int64_t first_index,
                               double t_server_s) {
  LAB_CHECK(rows.size() <= 0xFFFF, rows.size());
  std::string out(kFrameHeaderBytes + rows.size() * kRowBytes, '\0');
  char* at = out.data();
  at = Put(at, kVersion);
  at = Put(at, kTypeFrames);
  at = Put(at, static_cast<std::uint16_t>(rows.size()));
  at = Put(at, static_cast<std::uint32_t>(first_index));
  at = Put(at, t_server_s);
  for (const StreamRow& row : rows) at = Put(at, row.values);
  for (const StreamRow& row : rows) at = Put(at, row.statuses);
  return out;
}

}  // namespace faultlab::server

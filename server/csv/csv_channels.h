#pragma once

#include <array>
#include <cstddef>
#include <string_view>

#include "core/types/sample.h"

namespace faultlab::server {

/// One column of a recording and the member of a sample that holds its number.
struct CsvChannel {
  std::string_view name;
  double core::Sample::*member;
  bool required;  ///< the file must have it; ia_a or n_rpm may replace um_v
  bool finite;    ///< every row must have a number in it
};

/// Canonical order: time, command, then what the converters read.
inline constexpr std::array<CsvChannel, 7> kCsvChannelTable = {{
    {"t_s", &core::Sample::t_s, true, true},
    {"uc_v", &core::Sample::uc_v, true, true},
    {"um_v", &core::Sample::um_v, true, false},
    {"ua_v", &core::Sample::ua_v, false, false},
    {"ia_a", &core::Sample::ia_a, false, false},
    {"n_rpm", &core::Sample::n_rpm, false, false},
    {"delta_s", &core::Sample::delta_s, false, false},
}};

/// Columns of a file, with those that are not of a recording.
inline constexpr std::size_t kCsvColumnsMax = 256;

inline constexpr std::size_t kCommandChannel = 1;
/// A recording must have one of these measurements: um, ia on benches without um, n on benches with
/// neither.
inline constexpr std::size_t kUmChannel = 2;
inline constexpr std::size_t kCurrentChannel = 4;
inline constexpr std::size_t kSpeedChannel = 5;
inline constexpr std::array<std::size_t, 3> kMeasurements = {
    kUmChannel, kCurrentChannel, kSpeedChannel};

/// @param has  of a place in the table: is the channel there?
constexpr bool HasMeasurement(auto has) {
  return has(kMeasurements[0]) || has(kMeasurements[1]) || has(kMeasurements[2]);
}

}  // namespace faultlab::server

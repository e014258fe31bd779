#pragma once

#include <string>
#include <vector>

#include "core/types/result.h"
#include "server/json/json_reader.h"
#include "server/lab/lab_types.h"

// Times that come again, as iCalendar (RFC 5545) describes them; libical unrolls them.
namespace faultlab::server {

struct Recurrence {
  std::string start;                ///< of the first time, RFC 3339
  std::string end;                  ///< of the first time
  std::string repeat;               ///< an RRULE with COUNT or UNTIL; empty: once
  std::string time_zone;            ///< IANA name: a time keeps its hour there; "UTC" by default
  std::vector<std::string> except;  ///< dates there, "2026-12-24", on which there is none
};

/// Reads `start` and `end`, and with `again` `repeat`, `time_zone` and `except`.
Recurrence ReadRecurrence(ObjectReader& in, bool again);

inline constexpr int kTimesMax = 1000;
/// In order, none overlaps another; at most kTimesMax, all within two years of the first.
core::Result<std::vector<lab::Interval>> TimesOf(const Recurrence& wanted);

}  // namespace faultlab::server

#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/types/result.h"
#include "server/wall_time.h"

namespace faultlab::server {

/// "2026-11-21T01:02:03.456Z"
std::string Iso8601(WallTime time);
/// "20261121T010203Z", as iCalendar (RFC 5545) writes it.
std::string BasicIso8601(WallTime time);
/// RFC 3339 with Z or an offset; seconds may be absent, digits behind the millisecond are dropped.
/// Names of zones and times without a zone are refused: on the day of a clock change they mean two
/// instants or none. The Error carries `field`.
core::Result<WallTime> ParseIso8601(std::string_view text, const std::string& field);
/// Midnight (UTC) of the date that `text` begins with, "2026-11-21..".
std::optional<WallTime> LeadingDate(std::string_view text);

}  // namespace faultlab::server

#include "server/api/iso8601.h"

#include <date/date.h>

#include <regex>
#include <sstream>

namespace faultlab::server {
namespace {

std::optional<WallTime> Parse(const std::string& text, const std::string& format) {
  std::istringstream in(text);
  WallTime time;
  date::from_stream(
      in, format.c_str(), time);  // not date::parse: std has a from_stream too, from gcc 14 on
  if (in.fail()) return std::nullopt;
  return time;
}

/// An offset may lead out of the years 0 to 9999, which could be written but not read again.
bool HasFourDigitYear(WallTime time) {
  using namespace std::chrono;
  return time >= sys_days(year(0) / 1 / 1) && time < sys_days(year(10000) / 1 / 1);
}

}  // namespace

std::string Iso8601(WallTime time) {
  return date::format("%FT%TZ", time);
}

std::string BasicIso8601(WallTime time) {
  return date::format("%Y%m%dT%H%M%SZ", date::floor<std::chrono::seconds>(time));
}

core::Result<WallTime> ParseIso8601(std::string_view text, const std::string& field) {
  // The shape first: date::parse alone takes "26-1-1T1:2Z" and an offset of 25 hours.
  static const std::regex kShape(R"((\d{4}-\d\d-\d\dT\d\d:\d\d)(?:(:\d\d)(?:(\.\d{1,3})\d{0,6})?)?)"
                                 R"((Z|[+-](?:0\d|1[0-4]):[0-5]\d))");
  std::match_results<std::string_view::const_iterator> part;
  if (std::regex_match(text.begin(), text.end(), part, kShape)) {
    const std::string seconds = part[2].matched ? part[2].str() + part[3].str() : ":00";
    const std::string zone = part[4] == "Z" ? "+00:00" : part[4].str();
    const auto time = Parse(part[1].str() + seconds + zone, "%FT%T%Ez");
    if (time && HasFourDigitYear(*time)) return *time;
  }
  return core::Error{core::ErrorCode::kInvalid,
                     "Give a time as 2026-11-21T10:00:00Z or with an offset as +01:00.",
                     field,
                     "time_unreadable"};
}

std::optional<WallTime> LeadingDate(std::string_view text) {
  static const std::regex kShape(R"(\d{4}-\d\d-\d\d)");
  const std::string day(text.substr(0, 10));
  if (!std::regex_match(day, kShape)) return std::nullopt;
  return Parse(day, "%F");
}

}  // namespace faultlab::server

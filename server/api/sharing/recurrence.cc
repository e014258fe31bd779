#include "server/api/sharing/recurrence.h"

#include <date/tz.h>
#include <libical/ical.h>

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <string_view>

#include "server/api/iso8601.h"

namespace faultlab::server {
namespace {

using WholeSeconds = std::chrono::seconds;
using LocalTime = date::local_time<WholeSeconds>;

constexpr auto kSpanMax = std::chrono::hours(24 * 366 * 2);
/// What comes after the span is looked for so far, to be refused.
constexpr auto kBeyond = std::chrono::hours(24 * 400);
constexpr std::size_t kExceptMax = 200;

const date::time_zone* FindZone(const std::string& name) {
  try {
    return date::locate_zone(name.empty() ? "UTC" : name);
  } catch (const std::runtime_error&) {
    return nullptr;  // no such zone, or no zones on this machine
  }
}

/// An hour that a clock change leaves out is the moment of the change; of one that it repeats, the
/// first.
WallTime Instant(const date::time_zone& zone, LocalTime local) {
  return zone.to_sys(local, date::choose::earliest);
}

icaltimetype ToIcal(LocalTime local) {
  const auto day = date::floor<date::days>(local);
  const date::year_month_day date{day};
  const date::hh_mm_ss clock{local - day};
  icaltimetype out = icaltime_null_time();
  out.year = int{date.year()};
  out.month = static_cast<int>(unsigned{date.month()});
  out.day = static_cast<int>(unsigned{date.day()});
  out.hour = static_cast<int>(clock.hours().count());
  out.minute = static_cast<int>(clock.minutes().count());
  out.second = static_cast<int>(clock.seconds().count());
  return out;
}

LocalTime FromIcal(const icaltimetype& time) {
  return date::local_days{date::year(time.year) / time.month / time.day} +
         std::chrono::hours(time.hour) + std::chrono::minutes(time.minute) +
         WholeSeconds(time.second);
}

/// UNTIL is an instant, or the whole of a date in the zone.
icaltimetype LocalUntil(const icaltimetype& until, const date::time_zone& zone) {
  if (until.is_date != 0) return ToIcal(FromIcal(until) + std::chrono::hours(24) - WholeSeconds(1));
  if (icaltime_is_utc(until) == 0) return until;
  const date::sys_time<WholeSeconds> instant{FromIcal(until).time_since_epoch()};
  return ToIcal(zone.to_local(instant));
}

/// libical searches a rule that matches nothing for centuries; by hours and seconds it would never
/// end.
bool HasKnownPartsOnly(std::string_view rule) {
  constexpr std::array<std::string_view, 9> kKnown = {
      "FREQ", "INTERVAL", "COUNT", "UNTIL", "BYDAY", "BYMONTHDAY", "BYMONTH", "BYSETPOS", "WKST"};
  while (!rule.empty()) {
    const std::string_view part = rule.substr(0, rule.find(';'));
    if (std::ranges::find(kKnown, part.substr(0, part.find('='))) == kKnown.end()) return false;
    rule.remove_prefix(std::min(part.size() + 1, rule.size()));
  }
  return true;
}

struct Rule {
  icalrecurrencetype ical;
  int most = 0;  ///< times, exceptions included
};

core::Result<Rule> ReadRule(const std::string& text, const date::time_zone& zone, LocalTime first) {
  if (!HasKnownPartsOnly(text)) return core::Refuse("repeat_unreadable", "/repeat");
  icalrecurrencetype rule = icalrecurrencetype_from_string(text.c_str());
  if (rule.freq == ICAL_SECONDLY_RECURRENCE || rule.freq == ICAL_MINUTELY_RECURRENCE ||
      rule.freq == ICAL_HOURLY_RECURRENCE) {
    return core::Refuse("repeat_often", "/repeat");
  }
  // libical reads it of months alone.
  const bool unread =
      rule.freq != ICAL_MONTHLY_RECURRENCE && text.find("BYSETPOS") != std::string::npos;
  if (unread) return core::Refuse("repeat_unreadable", "/repeat");
  const bool known = rule.freq == ICAL_DAILY_RECURRENCE || rule.freq == ICAL_WEEKLY_RECURRENCE ||
                     rule.freq == ICAL_MONTHLY_RECURRENCE;
  if (!known) return core::Refuse("repeat_unreadable", "/repeat");
  const bool until = icaltime_is_null_time(rule.until) == 0;
  if (rule.count <= 0 && !until) return core::Refuse("repeat_endless", "/repeat");
  // Both ends are watched here: libical takes one of them only.
  const icaltimetype last = ToIcal(first + kSpanMax + kBeyond);
  const icaltimetype asked = until ? LocalUntil(rule.until, zone) : last;
  const int most = rule.count > 0 ? rule.count : kTimesMax + 1;
  rule.until = icaltime_compare(asked, last) < 0 ? asked : last;
  rule.count = 0;
  return Rule{rule, most};
}

}  // namespace

Recurrence ReadRecurrence(ObjectReader& in, bool again) {
  Recurrence out;
  out.start = in.Text("start", 40);
  out.end = in.Text("end", 40);
  if (!again) return out;
  out.repeat = in.TextOr("repeat", "", 500);
  out.time_zone = in.TextOr("time_zone", "UTC", 64);
  if (const auto* except = in.ArrayOrNull("except", kExceptMax)) {
    for (const auto& each : *except) {
      const auto* text = each.if_string();
      const bool is_date = text != nullptr && text->size() == 10 && LeadingDate(*text);
      if (!is_date) {
        in.Refuse("except", "date_unreadable");
        break;
      }
      out.except.emplace_back(*text);
    }
  }
  return out;
}

core::Result<std::vector<lab::Interval>> TimesOf(const Recurrence& wanted) {
  TRY(const auto start, ParseIso8601(wanted.start, "/start"));
  TRY(const auto end, ParseIso8601(wanted.end, "/end"));
  if (end - start > kSpanMax) return core::Refuse("repeat_too_long", "/end", {{"most", kTimesMax}});
  if (wanted.repeat.empty()) return std::vector<lab::Interval>{{start, end}};
  if (end <= start) return core::Refuse("end_before_start", "/end");
  const date::time_zone* const zone = FindZone(wanted.time_zone);
  if (zone == nullptr) {
    return core::Refuse("time_zone_unknown", "/time_zone", {{"zone", wanted.time_zone}});
  }
  const LocalTime first = zone->to_local(date::floor<WholeSeconds>(start));
  TRY(const auto rule, ReadRule(wanted.repeat, *zone, first));
  const auto length = zone->to_local(date::floor<WholeSeconds>(end)) - first;
  const std::unique_ptr<icalrecur_iterator, decltype(&icalrecur_iterator_free)> rolled(
      icalrecur_iterator_new(rule.ical, ToIcal(first)), &icalrecur_iterator_free);
  if (rolled == nullptr) return core::Refuse("repeat_unreadable", "/repeat");
  std::vector<lab::Interval> times;
  int found = 0;
  for (; found < rule.most; ++found) {
    const icaltimetype next = icalrecur_iterator_next(rolled.get());
    if (icaltime_is_null_time(next) != 0) break;
    const LocalTime local = FromIcal(next);
    if (found == 0 && local != first) break;
    const lab::Interval time{Instant(*zone, local), Instant(*zone, local + length)};
    if (found == kTimesMax || time.start - start > kSpanMax) {
      return core::Refuse("repeat_too_long", "/repeat", {{"most", kTimesMax}});
    }
    if (std::ranges::find(wanted.except, date::format("%F", local)) != wanted.except.end())
      continue;
    if (!times.empty() && times.back().end > time.start) {
      return core::Refuse("repeat_overlaps", "/repeat");
    }
    if (time.start < time.end) times.push_back(time);
  }
  if (found == 0) return core::Refuse("repeat_misses_start", "/repeat");
  if (times.empty()) return core::Refuse("repeat_leaves_none", "/except");
  return times;
}

}  // namespace faultlab::server

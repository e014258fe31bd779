#include "server/lab/opening.h"

#include <algorithm>

namespace faultlab::server::lab {
namespace {

/// Longer than the longest session with all of its extensions (kPolicySettings), and the check.
constexpr Milliseconds kLongest = std::chrono::hours(49);
constexpr Milliseconds kFirstLook = std::chrono::hours(1);

}  // namespace

std::vector<Shut> ShutTimes(const LabState& state,
                            const std::string& rig_class,
                            const Courses& courses,
                            const Interval& range) {
  std::vector<Shut> shut;
  std::vector<Interval> open;
  bool has_hours = false;
  for (const auto& [id, window] : state.windows) {
    if (window.rig_class != rig_class) continue;
    const bool everybody = window.course == 0;
    has_hours = has_hours || everybody;
    const bool theirs = everybody || std::ranges::binary_search(courses, window.course);
    auto each = std::ranges::partition_point(
        window.times, [&](const Interval& time) { return time.end <= range.start; });
    for (; each != window.times.end() && each->start < range.end; ++each) {
      if (theirs) open.push_back(*each);
      if (!theirs) shut.push_back({*each, &window});
    }
  }
  if (!has_hours) return shut;
  std::ranges::sort(open);
  WallTime closed_from = range.start;
  for (const Interval& each : open) {
    if (each.start > closed_from) shut.push_back({{closed_from, each.start}, nullptr});
    closed_from = std::max(closed_from, each.end);
  }
  if (closed_from < range.end) shut.push_back({{closed_from, range.end}, nullptr});
  return shut;
}

WallTime NextShut(const LabState& state,
                  const std::string& rig_class,
                  const Courses& courses,
                  WallTime from) {
  if (state.windows.empty()) return WallTime::max();
  // Most often it is near.
  for (Milliseconds ahead = kFirstLook; ahead < 2 * kLongest; ahead *= 4) {
    WallTime next = WallTime::max();
    for (const Shut& each : ShutTimes(state, rig_class, courses, {from, from + ahead})) {
      next = std::min(next, std::max(from, each.during.start));
    }
    if (next != WallTime::max()) return next;
  }
  return WallTime::max();
}

WallTime NextOpen(const LabState& state,
                  const std::string& rig_class,
                  const Courses& courses,
                  const Interval& range) {
  std::vector<Interval> shut;
  for (const Shut& each : ShutTimes(state, rig_class, courses, range)) {
    shut.push_back(each.during);
  }
  std::ranges::sort(shut);
  WallTime open = range.start;
  for (const Interval& each : shut) {
    if (each.start > open) break;
    open = std::max(open, each.end);
  }
  return open >= range.end ? WallTime::max() : open;
}

core::Status CheckOpen(const LabState& state,
                       const std::string& rig_class,
                       const Courses& courses,
                       const Interval& during) {
  const std::vector<Shut> shut = ShutTimes(state, rig_class, courses, during);
  if (shut.empty()) return core::Done{};
  const Window* const of = shut.front().of;
  if (of == nullptr) return core::Refuse("class_closed", "start");
  return core::Refuse("hours_of_course", "start", {{"title", of->title}});
}

}  // namespace faultlab::server::lab

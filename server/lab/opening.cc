#include "server/lab/opening.h"

#include <algorithm>

#include "server/lab/scheduler.h"
#include "server/lab/timeline.h"

namespace faultlab::server::lab {
namespace {

/// Longer than the longest session with all of its extensions (kPolicySettings), and the check.
constexpr Milliseconds kLongest = std::chrono::hours(49);
constexpr Milliseconds kFirstLook = std::chrono::hours(1);
/// Hours that are over are still shown so long.
constexpr Milliseconds kShownAfter = std::chrono::hours(24 * 7);

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

WallTime Scheduler::RoomUntil(const Rig& rig, const Courses& courses, WallTime from) const {
  return std::min(NextCommitment(state_, rig.id, from),
                  NextShut(state_, rig.rig_class, courses, from));
}

core::Result<Window> Scheduler::AddWindow(Window window, WallTime now) {
  const auto of_class = [&](const auto& entry) {
    return entry.second.rig_class == window.rig_class;
  };
  if (!HasClass(state_, window.rig_class)) return core::Refuse("no_rig_class");
  if (IsElastic(window.rig_class)) return core::Refuse("class_always_open");
  if (std::ranges::count_if(state_.windows, of_class) >= kWindowsMax) {
    return core::Refuse("windows_full", "", {{"most", kWindowsMax}});
  }
  for (const auto& entry : state_.windows) {
    const Window& other = entry.second;
    const bool rival = other.rig_class == window.rig_class && other.course != window.course &&
                       other.course != 0 && window.course != 0;
    if (!rival) continue;
    for (const Interval& mine : window.times) {
      const auto met = [&](const Interval& theirs) { return theirs.Overlaps(mine); };
      if (std::ranges::none_of(other.times, met)) continue;
      return core::Refuse(
          "window_overlaps", "/start", {{"title", other.title}, {"time", UtcText(mine.start)}});
    }
  }
  const auto of_course = [&](const auto& entry) {
    return of_class(entry) && entry.second.course == window.course;
  };
  if (window.course != 0 && std::ranges::count_if(state_.windows, of_course) >= kOfCourseMax) {
    return core::Refuse("windows_full", "", {{"most", kOfCourseMax}});
  }
  window.id = WindowId{NewNumber()};
  state_.windows[window.id] = window;
  touched_windows_.insert(window.id);
  Tick(now);
  return window;
}

core::Status Scheduler::RemoveWindow(WindowId id, WallTime now) {
  if (state_.windows.erase(id) == 0) return core::Refuse("no_window");
  touched_windows_.erase(id);
  ended_windows_.push_back(id);
  Tick(now);
  return core::Done{};
}

void Scheduler::TickWindows(WallTime now) {
  const auto last_end = [](const Window& window) { return window.times.back().end; };
  std::erase_if(state_.windows, [&](const auto& entry) {
    const Window& window = entry.second;
    if (last_end(window) + kShownAfter > now) return false;
    const bool goes =
        window.course != 0 || std::ranges::any_of(state_.windows, [&](const auto& each) {
          const Window& other = each.second;
          return other.course == 0 && other.rig_class == window.rig_class &&
                 last_end(other) > last_end(window);
        });
    if (goes) ended_windows_.push_back(window.id);
    return goes;
  });
}

}  // namespace faultlab::server::lab

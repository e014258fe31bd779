// Rule 13 of the README: opening hours, and hours of courses.
#include <algorithm>

#include "server/lab/opening.h"
#include "server/lab/scheduler.h"
#include "server/lab/timeline.h"

namespace faultlab::server::lab {
namespace {

/// Hours that are over are still shown so long.
constexpr Milliseconds kShownAfter = std::chrono::hours(24 * 7);

}  // namespace

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

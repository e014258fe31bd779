// rig-classes/{rig_class}/hours: opening hours, and hours that a course has for itself.
#include <algorithm>
#include <boost/json.hpp>

#include "server/api/sharing/lists.h"
#include "server/api/sharing/recurrence.h"
#include "server/json/json_reader.h"
#include "server/lab/opening.h"
#include "server/lab/timeline.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using lab::Window;

constexpr std::int64_t kCoursesMax = INT64_MAX;
constexpr std::ptrdiff_t kNextShown = 20;

json::object TimeToJson(const lab::Interval& time) {
  return {{"start", Iso8601(time.start)}, {"end", Iso8601(time.end)}};
}

json::object WindowToJson(const Window& window, WallTime now) {
  const auto next = std::ranges::partition_point(
      window.times, [&](const lab::Interval& time) { return time.end <= now; });
  const std::ptrdiff_t shown = std::min(kNextShown, window.times.end() - next);
  return {{"id", Number(window.id)},
          {"rig_class", window.rig_class},
          {"course", window.course == 0 ? json::value() : json::value(window.course)},
          {"title", window.title},
          {"repeat", window.repeat},
          {"time_zone", window.time_zone},
          {"times", window.times.size()},
          {"next", ListOf(std::vector(next, next + shown), TimeToJson)},
          {"last_end", Iso8601(window.times.back().end)}};
}

/// In the audit log.
std::string HoursObject(const Window& window) {
  if (window.course == 0) return "rig_class:" + window.rig_class;
  return "course:" + std::to_string(window.course);
}

/// Opening hours are the lab's; a course has its hours from its teachers.
core::Status MayChange(Api& api, const ApiRequest& request, std::int64_t course) {
  if (course == 0) return Authorize(request.who, Operation::kManagePolicy, Ownership::kNone);
  TRY(const auto whose, api.accounts.InCourse(request.who.user_id, course));
  const bool teaches = whose == Ownership::kOwn;
  return Authorize(
      request.who, Operation::kManageCourse, teaches ? Ownership::kOwn : Ownership::kForeign);
}

core::Result<HttpResponse> ListHours(Api& api, const ApiRequest& request) {
  const std::string& rig_class = request.http.PathParameter("rig_class");
  const auto state = api.service.state();
  if (!lab::HasClass(*state, rig_class)) return core::Refuse("no_rig_class");
  json::array items;
  for (const auto& [id, window] : state->windows) {
    if (window.rig_class == rig_class) items.push_back(WindowToJson(window, api.clock.Wall()));
  }
  return ListAnswer(std::move(items));
}

core::Result<HttpResponse> CreateHours(Api& api, const ApiRequest& request) {
  ObjectReader in(request.body, "");
  Window window;
  window.rig_class = request.http.PathParameter("rig_class");
  window.title = in.Text("title", 120);
  window.course = in.IntegerOr("course", 0, 1, kCoursesMax);
  const Recurrence wanted = ReadRecurrence(in, /*again=*/true);
  if (auto error = in.Finish()) return *error;
  TRY_DONE(MayChange(api, request, window.course));
  if (window.course != 0) {
    TRY(const auto found, api.accounts.FindCourse(window.course));
    if (!found) return core::Refuse("no_course", "/course");
  }
  TRY(window.times, TimesOf(wanted));
  if (window.times.front().end <= window.times.front().start) {
    return core::Refuse("end_before_start", "/end");
  }
  window.repeat = wanted.repeat;
  window.time_zone = wanted.time_zone;
  // What was promised stays: who made these hours is told how much of it lies in the way.
  int kept = 0;
  TRY(const auto made,
      api.service.Do([&](lab::Scheduler& scheduler, WallTime now) -> core::Result<Window> {
        const auto in_the_way = [&] {
          return std::ranges::count_if(scheduler.state().bookings, [&](const auto& each) {
            const lab::Booking& booking = each.second;
            return booking.state != lab::BookingState::kWaiting &&
                   booking.rig_class == window.rig_class &&
                   !lab::CheckOpen(
                        scheduler.state(), booking.rig_class, booking.courses, booking.during)
                        .ok();
          });
        };
        const auto before = in_the_way();
        TRY(auto added, scheduler.AddWindow(window, now));
        kept = static_cast<int>(std::max<std::ptrdiff_t>(0, in_the_way() - before));
        return added;
      }));
  api.audit.Add(request.who,
                "add_hours",
                HoursObject(made),
                made.title + ": " + wanted.start + " " + wanted.end + " " + wanted.repeat);
  json::object out = WindowToJson(made, api.clock.Wall());
  out["bookings_kept"] = kept;
  return JsonResponse(out, 201);
}

core::Result<HttpResponse> DeleteHours(Api& api, const ApiRequest& request) {
  TRY(const auto number, PathNumber(request));
  const lab::WindowId id{number};
  const auto state = api.service.state();
  const auto found = state->windows.find(id);
  if (found == state->windows.end() ||
      found->second.rig_class != request.http.PathParameter("rig_class")) {
    return core::Refuse("no_window");
  }
  const Window& gone = found->second;
  TRY_DONE(MayChange(api, request, gone.course));
  TRY_DONE(api.service.Do(
      [&](lab::Scheduler& scheduler, WallTime now) { return scheduler.RemoveWindow(id, now); }));
  api.audit.Add(request.who, "remove_hours", HoursObject(gone), gone.title);
  return NoContent();
}

}  // namespace

std::span<const ApiRoute> HoursRoutes() {
  using namespace routing;
  static constexpr auto kRoutes = std::to_array<ApiRoute>({
      {kGet, "rig-classes/{rig_class}/hours", kListRigs, kRole, ListHours},
      {kPost, "rig-classes/{rig_class}/hours", kManageCourse, kRole, CreateHours, kJson},
      {kDelete, "rig-classes/{rig_class}/hours/{id}", kManageCourse, kRole, DeleteHours},
  });
  return kRoutes;
}

}  // namespace faultlab::server

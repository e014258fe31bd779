// calendar.ics, calendar-link.
#include <boost/json.hpp>

#include "core/types/utf8.h"
#include "server/api/sharing/lists.h"
#include "server/auth/calendar_links.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using lab::UserId;

std::string CalendarText(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == ',' || c == ';' || c == '\\') out += '\\';
    if (c == '\n') {
      out += "\\n";
    } else if (static_cast<unsigned char>(c) >= 0x20) {
      out += c;
    }
  }
  return out;
}

/// A content line of RFC 5545: at most 75 bytes, continued after a space, and no letter is cut.
std::string Folded(std::string_view line) {
  constexpr std::size_t kMost = 75;
  std::string out;
  std::size_t most = kMost;
  while (line.size() > most) {
    const std::string_view part = core::CutUtf8(line, most);
    out.append(part).append("\r\n ");
    line.remove_prefix(part.size());
    most = kMost - 1;
  }
  return out.append(line).append("\r\n");
}

core::Result<HttpResponse> CalendarOf(Api& api, UserId user) {
  const auto state = api.service.state();
  const std::string stamp = BasicIso8601(api.clock.Wall());
  std::string out =
      "BEGIN:VCALENDAR\r\nVERSION:2.0\r\nPRODID:-//faultlab//bookings//EN\r\n"
      "CALSCALE:GREGORIAN\r\n";
  for (const auto& [id, booking] : state->bookings) {
    if (booking.user != user) continue;
    const bool waits = booking.state == lab::BookingState::kWaiting;
    out += "BEGIN:VEVENT\r\nUID:booking-" + std::to_string(Number(id)) +
           "@faultlab\r\nDTSTAMP:" + stamp + "\r\nDTSTART:" + BasicIso8601(booking.during.start) +
           "\r\nDTEND:" + BasicIso8601(booking.during.end) +
           "\r\nSEQUENCE:" + std::to_string(booking.version) +
           "\r\nSTATUS:" + (waits ? "TENTATIVE" : "CONFIRMED") + "\r\n" +
           Folded("SUMMARY:" + CalendarText("Lab: " + booking.rig_class + " (" +
                                            (waits ? "waiting" : booking.rig) + ")")) +
           "END:VEVENT\r\n";
  }
  HttpResponse response;
  response.content_type = "text/calendar; charset=utf-8";
  response.body = out + "END:VCALENDAR\r\n";
  return response;
}

core::Result<HttpResponse> GetCalendar(Api& api, const ApiRequest& request) {
  return CalendarOf(api, UserId{request.who.user_id});
}

core::Result<HttpResponse> GetCalendarByLink(Api& api, const ApiRequest& request) {
  TRY(const auto account, api.calendar_links.AccountOf(request.http.PathParameter("token")));
  return CalendarOf(api, UserId{account});
}

core::Result<HttpResponse> GetCalendarLink(Api& api, const ApiRequest& request) {
  TRY(const auto created, api.calendar_links.CreatedAt(request.who.user_id));
  return JsonResponse(json::object{{"created_at", TimeOrNull(created)}});
}

core::Result<HttpResponse> CreateCalendarLink(Api& api, const ApiRequest& request) {
  TRY(const auto secret, api.calendar_links.Create(request.who.user_id, api.clock.Wall()));
  api.audit.Add(request.who, "create_calendar_link", request.who.owner_key(), "");
  return JsonResponse(json::object{{"link", "/api/v1/calendar/" + secret + ".ics"}}, 201);
}

core::Result<HttpResponse> RemoveCalendarLink(Api& api, const ApiRequest& request) {
  TRY_DONE(api.calendar_links.Remove(request.who.user_id));
  api.audit.Add(request.who, "remove_calendar_link", request.who.owner_key(), "");
  return NoContent();
}

}  // namespace

std::span<const ApiRoute> CalendarRoutes() {
  using namespace routing;
  static constexpr auto kRoutes = std::to_array<ApiRoute>({
      {kGet, "calendar.ics", kUseBooking, kRole, GetCalendar},
      {kGet, "calendar/{token}.ics", kReadPublic, kAnybody, GetCalendarByLink},
      {kGet, "calendar-link", kManageOwnAccount, kRole, GetCalendarLink},
      {kPost, "calendar-link", kManageOwnAccount, kRole, CreateCalendarLink, kEmptyForSecret},
      {kDelete, "calendar-link", kManageOwnAccount, kRole, RemoveCalendarLink},
  });
  return kRoutes;
}

}  // namespace faultlab::server

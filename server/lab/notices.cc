#include "server/lab/notices.h"

#include <algorithm>
#include <sstream>

namespace faultlab::server::lab {

int WarningStage(Milliseconds left) {
  return static_cast<int>(
      std::ranges::count_if(kWarnings, [&](Milliseconds each) { return left <= each; }));
}

std::string LeftText(Milliseconds left) {
  const auto s = std::chrono::ceil<std::chrono::seconds>(left).count();
  if (s < 120) return std::to_string(s) + " s left";
  return std::to_string((s + 30) / 60) + " minutes left";
}

std::string ReasonText(std::string_view reason, const std::string& why) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 10> kTexts = {
      {{"limit", "it has been extended as far as the policy allows"},
       {"queue", "somebody waits for this rig"},
       {"booking", "a booking begins"},
       {"outage", "planned outage"},
       {"hours", "the rigs are closed then, or for the people of a course"},
       {"rig_out", "the rig is out of service"},
       {"rig_gone", "the rig is gone"},
       {"none_free", "no rig became free in its time"},
       {"replanned", "so that one more booking has room"},
       {"clock", "the server's clock was set forward past its time"}}};
  const auto* const found =
      std::ranges::find_if(kTexts, [&](const auto& each) { return each.first == reason; });
  std::string text(found == kTexts.end() ? reason : found->second);
  if (!why.empty()) text += ": " + why;
  return text;
}

std::string WriteFallen(const Booking& booking) {
  return std::to_string(Number(booking.user)) + " " +
         std::to_string(ToMilliseconds(booking.during.start)) + " " +
         std::to_string(ToMilliseconds(booking.during.end)) + "\n";
}

std::vector<std::pair<UserId, Interval>> ReadFallen(const Outage& outage) {
  std::istringstream in(outage.fallen);
  std::vector<std::pair<UserId, Interval>> fallen;
  std::int64_t user = 0;
  std::int64_t start_ms = 0;
  std::int64_t end_ms = 0;
  while (in >> user >> start_ms >> end_ms) {
    fallen.push_back({UserId{user}, {FromMilliseconds(start_ms), FromMilliseconds(end_ms)}});
  }
  return fallen;
}

}  // namespace faultlab::server::lab

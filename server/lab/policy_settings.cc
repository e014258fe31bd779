#include "server/lab/policy_settings.h"

#include <utility>

namespace faultlab::server::lab {
namespace {

using core::Done;
using core::Error;

Error Outside(std::string_view name, std::int64_t least, std::int64_t most) {
  return core::Refuse("whole_number_outside",
                      "/" + std::string(name),
                      {{"member", name}, {"lowest", least}, {"highest", most}});
}

}  // namespace

std::int64_t ValueOf(const PolicySettings& settings, const PolicySetting& setting) {
  if (setting.count != nullptr) return settings.*setting.count;
  return (settings.*setting.time).count() / 1000;
}

void SetValue(PolicySettings& settings, const PolicySetting& setting, std::int64_t value) {
  if (setting.count != nullptr) {
    settings.*setting.count = static_cast<int>(value);
  } else {
    settings.*setting.time = Milliseconds{value * 1000};
  }
}

core::Status CheckSettings(const PolicySettings& settings) {
  for (const PolicySetting& each : kPolicySettings) {
    const std::int64_t value = ValueOf(settings, each);
    if (value < each.least || value > each.most) return Outside(each.name, each.least, each.most);
  }
  const auto seconds = [](Milliseconds time) { return time.count() / 1000; };
  if (settings.session_max < settings.session_min) {
    return Outside("session_max_s", seconds(settings.session_min), 86'400);
  }
  if (settings.booking_max < settings.booking_min) {
    return Outside("booking_max_s", seconds(settings.booking_min), 86'400);
  }
  return Done{};
}

std::string ChangedSettings(const PolicySettings& before, const PolicySettings& after) {
  std::string text;
  for (const PolicySetting& each : kPolicySettings) {
    const std::int64_t was = ValueOf(before, each);
    const std::int64_t is = ValueOf(after, each);
    if (was == is) continue;
    text += (text.empty() ? "" : ", ") + std::string(each.name) + " " + std::to_string(was) +
            " -> " + std::to_string(is);
  }
  return text;
}

std::int64_t WeekOf(WallTime time) {
  using Days = std::chrono::duration<std::int64_t, std::ratio<86'400>>;
  const std::int64_t day = std::chrono::floor<Days>(time.time_since_epoch()).count();
  return (day + 3) / 7;  // 1970-01-01 was a Thursday
}

std::string LengthText(Milliseconds length) {
  constexpr std::array<std::pair<std::int64_t, const char*>, 4> kUnits = {
      {{86'400, "day"}, {3600, "hour"}, {60, "minute"}, {1, "second"}}};
  const std::int64_t s = std::chrono::ceil<std::chrono::seconds>(length).count();
  for (const auto& [unit, name] : kUnits) {
    if (s < unit || s % unit != 0) continue;
    const std::int64_t count = s / unit;
    return std::to_string(count) + " " + name + (count == 1 ? "" : "s");
  }
  return "0 seconds";
}

}  // namespace faultlab::server::lab

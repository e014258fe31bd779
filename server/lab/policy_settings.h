#pragma once

#include <array>
#include <string>
#include <string_view>

#include "core/types/result.h"
#include "server/lab/lab_types.h"

namespace faultlab::server::lab {

/// One number that an admin may change. Durations are stored and shown in seconds.
struct PolicySetting {
  std::string_view name;
  Milliseconds PolicySettings::*time = nullptr;  ///< or
  int PolicySettings::*count = nullptr;
  std::int64_t least = 0;
  std::int64_t most = 0;
};

/// Under these names they are stored, audited and sent.
inline constexpr std::array<PolicySetting, 15> kPolicySettings = {{
    {"offer_s", &PolicySettings::offer, nullptr, 10, 600},
    {"grace_s", &PolicySettings::grace, nullptr, 30, 1800},
    {"extend_step_s", &PolicySettings::extend_step, nullptr, 60, 7200},
    {"extended_max_s", &PolicySettings::extended_max, nullptr, 0, 86'400},
    {"idle_s", &PolicySettings::idle, nullptr, 60, 7200},
    {"idle_answer_s", &PolicySettings::idle_answer, nullptr, 20, 600},
    {"session_min_s", &PolicySettings::session_min, nullptr, 60, 3600},
    {"session_max_s", &PolicySettings::session_max, nullptr, 300, 86'400},
    {"booking_min_s", &PolicySettings::booking_min, nullptr, 60, 14'400},
    {"booking_max_s", &PolicySettings::booking_max, nullptr, 300, 86'400},
    {"booking_ahead_s", &PolicySettings::booking_ahead, nullptr, 86'400, 31'536'000},
    {"no_show_charge_s", &PolicySettings::no_show_charge, nullptr, 0, 86'400},
    {"week_max_s", &PolicySettings::week_max, nullptr, 0, 604'800},
    {"live_bookings_max", nullptr, &PolicySettings::live_bookings_max, 0, 100},
    {"waiting_jobs_max", nullptr, &PolicySettings::waiting_jobs_max, 0, 1000},
}};

std::int64_t ValueOf(const PolicySettings& settings, const PolicySetting& setting);
/// Not checked: see CheckSettings.
void SetValue(PolicySettings& settings, const PolicySetting& setting, std::int64_t value);
/// Each within its limits, and no least above its most.
core::Status CheckSettings(const PolicySettings& settings);
/// "grace_s 180 -> 300, week_max_s 0 -> 36000"; empty: nothing has changed.
std::string ChangedSettings(const PolicySettings& before, const PolicySettings& after);

/// The number of the week since 1970, from Monday 0:00 UTC to Monday.
std::int64_t WeekOf(WallTime time);
/// "3 minutes", "45 seconds", "4 hours", "60 days": the largest unit that is whole.
std::string LengthText(Milliseconds length);

}  // namespace faultlab::server::lab

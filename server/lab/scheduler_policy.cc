// The numbers of the rules: of the lab, of a class, and of a person's week.
#include "server/lab/policy_settings.h"
#include "server/lab/scheduler.h"
#include "server/lab/timeline.h"

namespace faultlab::server::lab {

const PolicySettings& Scheduler::SettingsOf(const std::string& rig_class) const {
  const auto own = state_.settings.find(rig_class);
  return own == state_.settings.end() ? policy_ : own->second;
}

core::Result<PolicySettings> Scheduler::ChangePolicy(PolicySettings settings,
                                                     WallTime now,
                                                     const std::string& rig_class) {
  const auto own = state_.settings.find(rig_class);
  const std::int64_t newest = own == state_.settings.end() ? 0 : own->second.version;
  if (settings.version != newest) return core::Refuse("policy_changed");
  if (!rig_class.empty() && !HasClass(state_, rig_class)) return core::Refuse("no_rig_class");
  TRY_DONE(CheckSettings(settings));
  // A class that is given settings again must not have a version that it had before.
  settings.version = rig_class.empty() ? settings.version + 1 : NewNumber();
  if (rig_class.empty()) static_cast<PolicySettings&>(policy_) = settings;
  state_.settings[rig_class] = settings;
  touched_settings_.insert(rig_class);
  Tick(now);
  return settings;
}

core::Status Scheduler::DropPolicy(const std::string& rig_class, WallTime now) {
  if (rig_class.empty() || state_.settings.erase(rig_class) == 0) {
    return core::Refuse("no_own_policy");
  }
  touched_settings_.insert(rig_class);
  Tick(now);
  return core::Done{};
}

core::Status Scheduler::CheckWeek(UserId user,
                                  const std::string& rig_class,
                                  Milliseconds more,
                                  WallTime at) const {
  const Milliseconds most = SettingsOf(rig_class).week_max;
  if (most == Milliseconds{0} || IsElastic(rig_class)) return core::Done{};
  if (WeekUse(user, at) + more <= most) return core::Done{};
  return core::Refuse("week_full", "", {{"most", most / std::chrono::minutes(1)}});
}

}  // namespace faultlab::server::lab

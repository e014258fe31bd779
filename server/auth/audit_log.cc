#include "server/auth/audit_log.h"

#include <optional>

namespace faultlab::server {
namespace {

constexpr auto kHour = std::chrono::hours(1);
constexpr int kLinesOfObject = 30;
constexpr int kLinesOfVerb = 1000;
constexpr std::size_t kHoursMax = 10'000;

/// Lines of a verb in an hour; nothing: no limit.
std::optional<int> LinesOfActor(Role role) {
  switch (role) {
    case Role::kGuest:
    case Role::kStudent:
      return 200;
    case Role::kInstructor:
    case Role::kService:
      return 1000;
    case Role::kOperator:
    case Role::kAdmin:
      return std::nullopt;
  }
  return std::nullopt;
}

}  // namespace

void AuditLog::Add(const Principal& who,
                   const std::string& verb,
                   const std::string& object,
                   const std::string& detail) {
  const std::optional<int> lines_max = LinesOfActor(who.role);
  if (!lines_max) return Write(who, verb, object, detail);
  Counted counted;
  {
    const std::lock_guard lock(mutex_);
    counted = Count(who.owner_key() + " " + verb, *lines_max, clock_.Wall());
  }
  if (counted.write) Write(who, verb, object, detail + counted.remark);
}

void AuditLog::Write(const Principal& who,
                     const std::string& verb,
                     const std::string& object,
                     const std::string& detail) {
  const std::string actor = who.owner_key();
  const core::Status kept = accounts_.Audit(actor, verb, object, detail, clock_.Wall());
  if (kept.ok()) return;
  log_("audit: \"" + verb + " " + object + "\" by " + actor +
       " is not in the audit log: " + kept.error().message);
}

AuditLog::Counted AuditLog::Count(const std::string& key, int lines_max, WallTime now) {
  if (hours_.size() >= kHoursMax) {
    std::erase_if(hours_, [now](const auto& entry) { return now - entry.second.began >= kHour; });
    if (hours_.size() >= kHoursMax) hours_.clear();
  }
  Hour& hour = hours_.try_emplace(key, Hour{now}).first->second;
  Counted out;
  if (now - hour.began >= kHour || now < hour.began) {
    if (hour.left_out > 0) {
      out.remark = "; " + std::to_string(hour.left_out) + " before were left out";
    }
    hour = {now};
  }
  ++hour.lines;
  out.write = hour.lines <= lines_max;
  if (!out.write) ++hour.left_out;
  if (hour.lines == lines_max) out.remark += "; more of this hour are left out";
  return out;
}

void AuditLog::AddBounded(const AuditNote& note) {
  if (note.who.signed_in() && !LinesOfActor(note.who.role)) {
    return Write(note.who, note.verb, note.object, note.detail);
  }
  std::string detail = note.detail;
  {
    const std::lock_guard lock(mutex_);
    const WallTime now = clock_.Wall();
    const Counted object = Count(note.verb + " " + note.object, kLinesOfObject, now);
    if (!object.write) return;
    const Counted verb = Count(note.verb, kLinesOfVerb, now);
    if (!verb.write) return;
    detail += object.remark + verb.remark;
  }
  Write(note.who, note.verb, note.object, detail);
}

}  // namespace faultlab::server

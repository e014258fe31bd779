#include "server/app/daily_retention.h"

#include <string>
#include <utility>

namespace faultlab::server {

DailyRetention::DailyRetention(Database& database,
                               const Clock& clock,
                               RetentionRules rules,
                               std::function<void(std::string_view)> log)
    : database_(database),
      clock_(clock),
      rules_(rules),
      log_(std::move(log)),
      looks_(clock_, Repeated::First::kAtOnce, std::chrono::hours(24), [this] { Retain(); }) {}

void DailyRetention::Retain() {
  const auto kept = server::Retain(database_, rules_, clock_.Wall(), /*remove=*/true);
  if (!kept.ok()) {
    log_("retention: " + kept.error().message);
  } else if (!kept.value().items.empty()) {
    log_("retention: " + std::to_string(kept.value().items.size()) +
         " recordings and jobs were kept long enough and are gone");
  }
}

}  // namespace faultlab::server

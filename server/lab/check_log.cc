#include "server/lab/check_log.h"

#include <soci/soci.h>

#include <cmath>

namespace faultlab::server::lab {
namespace {

using soci::into;
using soci::use;

void AddSteps(Transaction& tx, std::int64_t check, const std::vector<CheckStep>& steps) {
  std::int64_t place = 0;
  for (const CheckStep& step : steps) {
    const std::int64_t passed = step.passed ? 1 : 0;
    CheckStep::Figure figure = step.figure.value_or(CheckStep::Figure{});
    const bool shown = step.figure && std::isfinite(figure.measured) && std::isfinite(figure.low) &&
                       std::isfinite(figure.high);
    if (!shown) figure = {};
    const std::int64_t has_figure = shown ? 1 : 0;
    tx.sql() << "INSERT INTO rig_check_step (check_id, place, step, subject, passed, has_figure, "
                "measured, low, high, unit, text) VALUES (:check, :place, :step, :subject, "
                ":passed, :has_figure, :measured, :low, :high, :unit, :text)",
        use(check, "check"), use(place, "place"), use(step.step, "step"),
        use(step.subject, "subject"), use(passed, "passed"), use(has_figure, "has_figure"),
        use(figure.measured, "measured"), use(figure.low, "low"), use(figure.high, "high"),
        use(figure.unit, "unit"), use(step.text, "text");
    ++place;
  }
}

std::vector<CheckStep> StepsOf(Transaction& tx, std::int64_t check) {
  std::string name;
  std::string subject;
  std::string unit;
  std::string text;
  std::int64_t passed = 0;
  std::int64_t has_figure = 0;
  double measured = 0.0;
  double low = 0.0;
  double high = 0.0;
  soci::statement query =
      (tx.sql().prepare << "SELECT step, subject, passed, has_figure, measured, low, high, unit, "
                           "text FROM rig_check_step WHERE check_id = :check ORDER BY place",
       into(name),
       into(subject),
       into(passed),
       into(has_figure),
       into(measured),
       into(low),
       into(high),
       into(unit),
       into(text),
       use(check, "check"));
  query.execute();
  std::vector<CheckStep> steps;
  while (query.fetch()) {
    CheckStep& step = steps.emplace_back();
    step.step = name;
    step.subject = subject;
    step.passed = passed != 0;
    step.text = text;
    if (has_figure != 0) step.figure.emplace(CheckStep::Figure{measured, low, high, unit});
  }
  return steps;
}

}  // namespace

core::Status CheckLog::Add(const CheckRecord& check) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    const std::int64_t at_ms = ToMilliseconds(check.at);
    const std::int64_t passed = check.passed ? 1 : 0;
    const int kept = kKept;
    std::int64_t id = 0;
    tx.sql() << "INSERT INTO rig_check (rig, at_ms, kind, passed, reason) "
                "VALUES (:rig, :at, :kind, :passed, :reason) RETURNING id",
        into(id), use(check.rig, "rig"), use(at_ms, "at"), use(check.kind, "kind"),
        use(passed, "passed"), use(check.reason, "reason");
    AddSteps(tx, id, check.steps);
    tx.sql() << "DELETE FROM rig_check_step WHERE check_id IN (SELECT id FROM rig_check "
                "WHERE rig = :rig ORDER BY id DESC LIMIT 1000 OFFSET :kept)",
        use(check.rig, "rig"), use(kept, "kept");
    tx.sql() << "DELETE FROM rig_check WHERE rig = :rig AND id NOT IN (SELECT id FROM rig_check "
                "WHERE rig = :same ORDER BY id DESC LIMIT :kept)",
        use(check.rig, "rig"), use(check.rig, "same"), use(kept, "kept");
    return core::Done{};
  });
}

core::Result<std::vector<CheckRecord>> CheckLog::List(const std::string& rig) {
  using Checks = std::vector<CheckRecord>;
  return database_.Read([&](Transaction& tx) -> core::Result<Checks> {
    Checks checks;
    CheckRecord check{.rig = rig};
    std::int64_t at_ms = 0;
    std::int64_t passed = 0;
    const int kept = kKept;
    soci::statement query =
        (tx.sql().prepare << "SELECT id, at_ms, kind, passed, reason FROM rig_check "
                             "WHERE rig = :rig ORDER BY id DESC LIMIT :kept",
         into(check.id),
         into(at_ms),
         into(check.kind),
         into(passed),
         into(check.reason),
         use(rig, "rig"),
         use(kept, "kept"));
    query.execute();
    while (query.fetch()) {
      check.at = FromMilliseconds(at_ms);
      check.passed = passed != 0;
      checks.push_back(check);
    }
    for (CheckRecord& each : checks) each.steps = StepsOf(tx, each.id);
    return checks;
  });
}

}  // namespace faultlab::server::lab

#include "server/lab/check_log.h"

#include <cmath>

#include "server/storage/rows.h"

namespace faultlab::server::lab {

template <typename Visit>
void Fields(CheckRecord& check, Visit&& visit) {
  visit("id", check.id);
  visit("rig", check.rig);
  visit("at_ms", check.at);
  visit("kind", check.kind);
  visit("passed", check.passed);
  visit("reason", check.reason);
}

namespace {

struct StepRow {
  std::int64_t check = 0;
  std::int64_t place = 0;
  CheckStep step;
  CheckStep::Figure figure;
  bool has_figure = false;
};

template <typename Visit>
void Fields(StepRow& row, Visit&& visit) {
  visit("check_id", row.check);
  visit("place", row.place);
  visit("step", row.step.step);
  visit("subject", row.step.subject);
  visit("passed", row.step.passed);
  visit("has_figure", row.has_figure);
  visit("measured", row.figure.measured);
  visit("low", row.figure.low);
  visit("high", row.figure.high);
  visit("unit", row.figure.unit);
  visit("text", row.step.text);
}

void AddSteps(Transaction& tx, std::int64_t check, const std::vector<CheckStep>& steps) {
  StepRow row;
  row.check = check;
  for (const CheckStep& step : steps) {
    row.step = step;
    row.figure = step.figure.value_or(CheckStep::Figure{});
    row.has_figure = step.figure && std::isfinite(row.figure.measured) &&
                     std::isfinite(row.figure.low) && std::isfinite(row.figure.high);
    if (!row.has_figure) row.figure = {};
    InsertRow(tx, "rig_check_step", row);
    ++row.place;
  }
}

std::vector<CheckStep> StepsOf(Transaction& tx, std::int64_t check) {
  std::vector<CheckStep> steps;
  const auto add = [&](const StepRow& row) {
    steps.push_back(row.step);
    if (row.has_figure) steps.back().figure = row.figure;
  };
  ForEachRow<StepRow>(
      tx, "rig_check_step WHERE check_id = :check ORDER BY place", add, {{"check", check}});
  return steps;
}

}  // namespace

core::Status CheckLog::Add(const CheckRecord& check) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) {
    const std::int64_t id = AddRow(tx, "rig_check", check);
    AddSteps(tx, id, check.steps);
    Execute(tx,
            "DELETE FROM rig_check_step WHERE check_id IN (SELECT id FROM rig_check "
            "WHERE rig = :rig ORDER BY id DESC LIMIT 1000 OFFSET :kept)",
            {{"rig", check.rig}, {"kept", kKept}});
    Execute(tx,
            "DELETE FROM rig_check WHERE rig = :rig AND id NOT IN (SELECT id FROM rig_check "
            "WHERE rig = :rig ORDER BY id DESC LIMIT :kept)",
            {{"rig", check.rig}, {"kept", kKept}});
  });
}

core::Result<std::vector<CheckRecord>> CheckLog::List(const std::string& rig) {
  return database_.Read([&](Transaction& tx) {
    auto checks = SelectRows<CheckRecord>(tx,
                                          "rig_check WHERE rig = :rig ORDER BY id DESC LIMIT :kept",
                                          {{"rig", rig}, {"kept", kKept}});
    for (CheckRecord& each : checks) each.steps = StepsOf(tx, each.id);
    return checks;
  });
}

}  // namespace faultlab::server::lab

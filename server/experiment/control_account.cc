#include "server/experiment/control_account.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/control/closed_loop/control_replay.h"
#include "core/control/closed_loop/orders.h"
#include "server/experiment/plan_json.h"
#include "server/run/run_messages.h"

namespace faultlab::server {
namespace {

using hardware::RigEvent;
using hardware::RigEventKind;

/// What the rig's events say of the drive.
void Follow(std::span<const RecordedEvent> events,
            const core::Bench& bench,
            ControlAccount& account) {
  const auto ends = [&](const RigEvent& event) {
    if (account.compensations.empty() || account.compensations.back().until_s) return;
    account.compensations.back().until_s = static_cast<double>(event.index) * account.period_s;
  };
  for (const RecordedEvent& recorded : events) {
    const auto event = ToRigEvent(recorded, bench);
    if (!event) continue;
    if (event->kind == RigEventKind::kControlBegan && !account.began) {
      account.began = static_cast<std::size_t>(event->index);
    } else if (event->kind == RigEventKind::kCompensationEnded) {
      // One that was refuted before it was made up for has none to end.
      if (account.compensations.empty() || account.compensations.back().until_s ||
          account.compensations.back().component != event->component) {
        continue;
      }
      ends(*event);
      account.compensations.back().ended = event->text;
    } else if (event->kind == RigEventKind::kCompensated) {
      const bool refines = !account.compensations.empty() &&
                           !account.compensations.back().until_s &&
                           account.compensations.back().component == event->component;
      if (refines) {
        account.compensations.back().value = event->value;
        continue;
      }
      ends(*event);
      account.compensations.push_back({.t_s = static_cast<double>(event->index) * account.period_s,
                                       .component = event->component,
                                       .value = event->value,
                                       .until_s = {},
                                       .ended = {}});
    }
  }
}

/// At most half a minute of it: more tells nothing new.
std::span<const core::Sample> Between(std::span<const core::Sample> samples,
                                      std::size_t from,
                                      std::size_t to) {
  constexpr std::size_t kMost = 3000;
  const auto at = [&](std::size_t index) {
    const auto found = std::ranges::lower_bound(
        samples, static_cast<std::int64_t>(index), {}, &core::Sample::index);
    return static_cast<std::size_t>(found - samples.begin());
  };
  const std::size_t first = at(from);
  return samples.subspan(first, std::min(kMost, std::max(at(to), first) - first));
}

}  // namespace

std::optional<ControlAccount> AccountOf(const Review& review) {
  const core::DiagnosisOptions& options = review.recording.options;
  const std::vector<core::Sample>& samples = review.recording.samples;
  auto planned = ControlOfPlan(review.recording.record.plan_json, *options.bench, options.period_s);
  if (!planned) return std::nullopt;
  ControlAccount account{.planned = *std::move(planned), .period_s = options.period_s};
  account.rad_per_s = core::RadPerSecondOfRpm(options.bench->nominal.gear_ratio);
  account.size = samples.empty() ? 0 : static_cast<std::size_t>(samples.back().index + 1);
  Follow(review.events, *options.bench, account);
  const auto sample_at = [&](double t_s) {
    return static_cast<std::size_t>(std::lround(std::max(t_s, 0.0) / options.period_s));
  };
  if (const auto& calibration = review.diagnosis.calibration) {
    const core::ControlOrder order =
        core::OrderOf(*options.bench, *calibration, review.diagnosis.verdict, options.period_s);
    account.reachable_rad_s =
        (order.believed ? order.believed->rig : order.healthy).reachable_rad_s();
    account.dither_rad_s =
        account.planned.wanted.options.dither_v * order.healthy.speed.RipplePerVolt();
  }
  account.reference_from = sample_at(account.planned.from_s);
  const core::ReferencePlayer player(account.planned.wanted.reference, options.period_s);
  account.reference_rad_s.assign(account.size, std::numeric_limits<double>::quiet_NaN());
  for (std::size_t k = account.reference_from; k < account.size; ++k) {
    account.reference_rad_s[k] = player.At(k - account.reference_from);
  }
  const std::vector<RigChange>& changes = review.story.changes;
  const double from_s =
      changes.empty() ? account.planned.from_s + core::kControlRunInS : changes.front().at_s;
  account.judged_from =
      std::max({sample_at(from_s), account.reference_from, account.began.value_or(0)});
  if (account.began && review.diagnosis.calibration) {
    const std::size_t healthy_to =
        changes.empty() ? account.size : std::min(account.size, sample_at(changes.front().at_s));
    account.visible = core::VisibleUnder(*options.bench,
                                         *review.diagnosis.calibration,
                                         Between(samples, *account.began, healthy_to),
                                         options.channels,
                                         options.um_rail_v);
  }
  return account;
}

std::optional<core::ControlQuality> QualityOf(const ControlAccount& account,
                                              std::span<const core::Sample> samples) {
  if (!account.began || account.judged_from >= account.size) return std::nullopt;
  std::vector<double> speed_rad_s(account.size, std::numeric_limits<double>::quiet_NaN());
  for (const core::Sample& sample : samples) {
    const auto index = static_cast<std::size_t>(sample.index);
    if (index < speed_rad_s.size()) speed_rad_s[index] = sample.n_rpm * account.rad_per_s;
  }
  return core::QualityOf(account.planned.wanted.reference,
                         {.reference_rad_s = account.reference_rad_s,
                          .speed_rad_s = speed_rad_s,
                          .control_from = account.reference_from,
                          .from = account.judged_from,
                          .period_s = account.period_s});
}

std::optional<std::vector<core::Sample>> WithoutDiagnosis(const ControlAccount& account,
                                                          const Review& review) {
  const Recording& recording = review.recording;
  const std::string& plan = recording.record.plan_json;
  const core::Bench& bench = *recording.options.bench;
  const core::BenchProfile* profile = bench.FindProfile(account.planned.profile);
  const auto& calibration = review.diagnosis.calibration;
  const auto seed = SeedOfPlan(plan);
  const bool whole = account.size == recording.samples.size();
  if (profile == nullptr || !calibration || !seed || !whole || HidesFaults(plan) ||
      !account.began || *account.began == 0 || *account.began < account.reference_from) {
    return std::nullopt;
  }
  core::ControlledRecord record;
  record.bench = &bench;
  record.profile = profile;
  std::vector<double> uc_v;
  for (const core::Sample& sample : recording.samples) uc_v.push_back(sample.uc_v);
  record.uc_v = uc_v;
  record.began = *account.began;
  record.reference_from = account.reference_from;
  record.reference = account.planned.wanted.reference;
  record.faults = FaultsToShow(review.story.changes, FaultsOfPlan(plan, bench));
  record.calibration = *calibration;
  record.period_s = account.period_s;
  record.seed = *seed;
  return core::WithoutCompensation(record);
}

}  // namespace faultlab::server

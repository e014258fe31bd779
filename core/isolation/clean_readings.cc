#include "core/isolation/clean_readings.h"

#include <algorithm>
#include <bit>

#include "core/filter/find_hum.h"
#include "core/filter/hum_tracker.h"
#include "core/isolation/ranked_hypotheses.h"
#include "core/types/time_span.h"

namespace faultlab::core {
namespace {

// Readings that are fitted at most (the newest): enough for every target, and it bounds the time.
constexpr std::size_t kReadingsMax = 1200;
// History that updates the prior: long enough, and ending well before the fault may have begun.
constexpr std::size_t kHistoryMin = 100;
// So far that nothing else can be behind them, and so few.
constexpr ImpulseRule kRare{.gate = 12.0, .share_max = 0.02};

// What is left of a hum that is known to be there must explain so much, in chi-square.
constexpr double kLeftHumGain = 16.0;

PredictionModel ModelWith(const FitContext& context, const HypothesisFit& fit) {
  const RigParameters rig = context.RigAt(fit.nuisance);
  return context.ModelOf(WithComponent(rig, fit.component, fit.value));
}

}  // namespace

CleanReadings::CleanReadings(const IsolationTask& task, const std::vector<Component>& components)
    : task_(task),
      components_(components),
      readings_(MakeObservations(task.samples,
                                 task.options.bench->readings(),
                                 task.options.channels,
                                 task.options.period_s,
                                 task.options.um_rail_v,
                                 ErrorsOf(*task.calibration),
                                 &t_s_)),
      fit_from_(std::min(task.fit_from, readings_.size())) {
  if (task.calibration->impulse_share > 0.0) in_newest_ = ImpulseRule{};
}

std::span<const Observation> CleanReadings::stretch() const {
  const std::size_t n = readings_.size();
  const auto channels = static_cast<std::size_t>(std::popcount(task_.calibration->mask()));
  const std::size_t most = SpanOf(kReadingsMax, task_.options.period_s) / channels;
  return all().subspan(std::max(fit_from_, n - std::min(n, most)));
}

std::span<const Observation> CleanReadings::history() const {
  const std::size_t gap = SpanOf(kHistoryGap, task_.options.period_s);
  const bool tells =
      task_.reference.empty() && fit_from_ >= SpanOf(kHistoryMin, task_.options.period_s) + gap;
  return all().first(tells ? fit_from_ - gap : 0);
}

void CleanReadings::LeaveOutKnown(const FitContext& nominal) {
  if (task_.calibration->impulse_share <= 0.0) return;
  const std::span<Observation> all(readings_);
  if (task_.reference.empty()) {
    LeaveOutImpulses(nominal.ModelOf(nominal.rig), all.first(fit_from_));
  }
  if (nominal.stretch.size() < 2) return;
  LeaveOut(nominal, all.subspan(fit_from_), {.or_the_farthest = true});
}

bool CleanReadings::LeaveOutRare(const FitContext& nominal,
                                 const HypothesisFit* nearest,
                                 const HypothesisFit* newest) {
  if (task_.calibration->impulse_share > 0.0) return false;
  before_ = readings_;
  in_newest_ = kRare;
  const std::size_t of_all =
      LeaveOut(nominal, std::span<Observation>(readings_).subspan(fit_from_), kRare, nearest);
  if (of_all > 0) newest = nullptr;
  (void)Newest(nominal, SpanOf(kLateSamples, task_.options.period_s), newest);
  return of_all > 0 || left_out_of_newest_ > 0;
}

bool CleanReadings::TakeOutHum(const FitContext& nominal) {
  if (!task_.calibration->hum.any()) return false;
  const Hum left = FindHum(Nearest(nominal),
                           since_fault(),
                           std::span<const double>(t_s_).subspan(fit_from_),
                           task_.options.period_s,
                           kLeftHumGain);
  if (!left.any()) return false;
  before_ = readings_;
  for (std::size_t k = fit_from_; k < readings_.size(); ++k) {
    Sample minus_hum;
    minus_hum.t_s = t_s_[k];
    minus_hum.um_v = minus_hum.ia_a = 0.0;
    minus_hum = WithoutHum(minus_hum, left);
    readings_[k].y[0] += minus_hum.um_v;
    readings_[k].y[1] += minus_hum.ia_a;
  }
  return true;
}

bool CleanReadings::HasLeftOut(std::size_t at) const {
  return at < before_.size() && readings_[at].mask != before_[at].mask;
}

void CleanReadings::PutBack() {
  if (before_.empty()) return;
  std::copy(before_.begin(), before_.end(), readings_.begin());
  in_newest_.reset();
}

// What is left out decides what comes nearest, and the other way round.
// @param context  of a stretch that shares its readings with `readings`
std::size_t CleanReadings::LeaveOut(const FitContext& context,
                                    std::span<Observation> readings,
                                    const ImpulseRule& rule,
                                    const HypothesisFit* nearest) const {
  constexpr int kRounds = 4;
  std::size_t all = 0;
  for (int round = 0; round < kRounds; ++round) {
    const bool known = round == 0 && nearest != nullptr;
    const PredictionModel model = known ? ModelWith(context, *nearest) : Nearest(context);
    const std::size_t more = LeaveOutImpulses(model, readings, rule);
    if (more == 0) break;
    all += more;
  }
  return all;
}

PredictionModel CleanReadings::Nearest(const FitContext& context) const {
  const RankedHypotheses ranked =
      RankHypotheses(context, components_, task_.options.values, FitPolicy::kStopLosers);
  return ModelWith(context, ranked.best());
}

FitContext CleanReadings::Newest(const FitContext& context,
                                 std::size_t samples,
                                 const HypothesisFit* nearest) {
  FitContext late = context;
  late.stretch = context.stretch.last(std::min(samples, context.stretch.size()));
  if (!in_newest_) return late;
  std::vector<Observation>& part = newest_.emplace_back(late.stretch.begin(), late.stretch.end());
  late.stretch = part;
  left_out_of_newest_ += LeaveOut(late, part, *in_newest_, nearest);
  return late;
}

}  // namespace faultlab::core

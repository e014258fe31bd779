#include "core/diagnosis/alarm_record.h"

#include <algorithm>
#include <array>
#include <utility>

namespace faultlab::core {
namespace {

// All spans are in samples at 100 Hz; faster records use more samples (SpanOf).
// The hypotheses are fitted at these samples after the alarm, and every kFitEvery samples after the
// last of them.
constexpr std::array<std::size_t, 6> kFitAt = {25, 50, 100, 200, 500, 1000};
// Before them, where what has come is large: only a sure answer counts.
constexpr std::array<std::size_t, 3> kEarlyAt = {4, 8, 16};
constexpr std::size_t kFitEvery = 500;
// What is not told yet is fitted at all multiples of kFitSoon, until as many samples as this.
constexpr std::size_t kFitSoon = 100;
constexpr std::size_t kFitSoonUntil = 1000;
// A fit of at least this many samples counts as settled: the paper's SWA window.
constexpr std::size_t kSettledAfter = 100;
// History kept before an alarm, and data kept after it.
constexpr std::size_t kHistory = 600;
constexpr std::size_t kHistoryBlock = 100;  // dropped at once
constexpr std::size_t kSegmentMax = 2000;

}  // namespace

std::vector<Sample> AlarmRecord::Newest(const std::vector<Sample>& samples) const {
  return {samples.end() - static_cast<std::ptrdiff_t>(std::min(samples.size(), Span(kHistory))),
          samples.end()};
}

AlarmRecord::AlarmRecord(double period_s) : period_s_(period_s) {
  history_.reserve(Span(kHistory) + kHistoryBlock);
}

void AlarmRecord::Remember(const Sample& sample) {
  if (history_.size() == Span(kHistory) + kHistoryBlock) {
    history_.erase(history_.begin(), history_.begin() + kHistoryBlock);
  }
  history_.push_back(sample);
}

void AlarmRecord::Append(const Sample& sample) {
  segment_.push_back(sample);
  ++since_alarm_;
}

void AlarmRecord::Open(const Alarm& alarm, bool alarmed) {
  std::vector<Sample> recent = Newest(alarmed ? segment_ : history_);
  segment_ = std::move(recent);
  segment_.reserve(Span(kSegmentMax) + Span(kHistory));
  history_.clear();
  alarm_at_ = segment_.size() - 1;
  const auto ago = std::min(alarm_at_, static_cast<std::size_t>(std::max(0, alarm.samples_ago)));
  fit_from_ = alarm.sharp ? alarm_at_ : alarm_at_ - ago;
  onset_t_s_ = segment_[alarm_at_ - ago].t_s;
  onset_.reset();
  onset_gone_ = false;
  since_alarm_ = 0;
  next_fit_ = Span(SeesSmallChanges(alarm.detector) ? kFitAt.front() : kEarlyAt.front());
}

void AlarmRecord::Close() {
  const std::vector<Sample> recent = Newest(segment_);
  history_.assign(recent.begin(), recent.end());
  segment_.clear();
}

bool AlarmRecord::HasBeenFitted() const {
  return since_alarm_ >= Span(kFitAt.front());
}

void AlarmRecord::ScheduleNextFit() {
  const auto is_later = [&](std::size_t at) { return Span(at) > since_alarm_; };
  const auto early = std::ranges::find_if(kEarlyAt, is_later);
  const auto later = std::ranges::find_if(kFitAt, is_later);
  next_fit_ = early != kEarlyAt.end() ? Span(*early)
              : later != kFitAt.end() ? Span(*later)
                                      : since_alarm_ + Span(kFitEvery);
}

void AlarmRecord::FitSoon() {
  if (since_alarm_ >= Span(kFitSoonUntil)) return;
  next_fit_ = std::min(next_fit_, (since_alarm_ / Span(kFitSoon) + 1) * Span(kFitSoon));
}

void AlarmRecord::Fill(IsolationTask& task) {
  if (segment_.size() > Span(kSegmentMax) + Span(kHistory)) {
    const std::size_t drop = segment_.size() - Span(kSegmentMax);
    segment_.erase(segment_.begin(), segment_.begin() + static_cast<std::ptrdiff_t>(drop));
    onset_gone_ = true;
    alarm_at_ -= std::min(alarm_at_, drop);
    fit_from_ -= std::min(fit_from_, drop);
  }
  task.samples = segment_;
  task.alarm_at = alarm_at_;
  task.fit_from = fit_from_;
  if (onset_gone_) task.onset = onset_.value_or(Onset{onset_t_s_, false});
  task.settled = since_alarm_ >= Span(kSettledAfter);
  task.early = !HasBeenFitted();
}

}  // namespace faultlab::core

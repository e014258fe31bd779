#include "core/diagnosis/fault_episodes.h"

#include <algorithm>
#include <optional>

namespace faultlab::core {
namespace {

void TakeDetection(const Verdict& first, Verdict& next) {
  next.further = first.further;
  next.detected_at_s = first.detected_at_s;
  next.onset_s = first.onset_s;
  next.detector = first.detector;
}

void ContinueFrom(const Verdict& first, Verdict& next) {
  const std::vector<Detection> now = DetectionsOf(next);
  TakeDetection(first, next);
  next.further.insert(next.further.end(), now.begin(), now.end());
}

}  // namespace

void FaultEpisodes::Open(const Verdict& verdict) {
  continued_.reset();
  if (open_) list_.back().ended_at_s = verdict.detected_at_s;
  list_.push_back({verdict, FaultShape::kAbrupt, std::nullopt});
  open_ = true;
}

void FaultEpisodes::Withdraw() {
  if (continued_) {
    list_.back() = *continued_;
    continued_.reset();
  } else {
    list_.pop_back();
  }
  open_ = false;
}

const Verdict& FaultEpisodes::Resume() {
  Withdraw();
  list_.back().ended_at_s.reset();
  open_ = true;
  return list_.back().verdict;
}

void FaultEpisodes::Update(Verdict& next, FaultShape shape, double alarm_t_s) {
  if (ContinuesTheOneBefore(next, alarm_t_s)) {
    list_.pop_back();
    continued_ = list_.back();
    list_.back().ended_at_s.reset();
  }
  if (continued_) ContinueFrom(continued_->verdict, next);
  list_.back().verdict = next;
  list_.back().shape = shape;
}

void FaultEpisodes::GoOn(Verdict& next) {
  TakeDetection(list_.back().verdict, next);
  list_.back().verdict = next;
  list_.back().shape = FaultShape::kDrift;
}

bool FaultEpisodes::ContinuesTheOneBefore(const Verdict& next, double alarm_t_s) const {
  if (continued_ || list_.size() < 2 || next.kind != VerdictKind::kFault) return false;
  const FaultEpisode& last = list_[list_.size() - 2];
  if (!last.ended_at_s || *last.ended_at_s != alarm_t_s) return false;
  const std::vector<Component>& then = last.verdict.group;
  return std::any_of(next.group.begin(), next.group.end(), [&](Component component) {
    return std::find(then.begin(), then.end(), component) != then.end();
  });
}

}  // namespace faultlab::core

// What is computed, stored and told when a run has ended.
#include <algorithm>
#include <boost/json.hpp>
#include <cmath>
#include <span>
#include <utility>

#include "server/diagnosis_json/diagnosis_json.h"
#include "server/diagnosis_json/options_json.h"
#include "server/run/run.h"
#include "server/storage/database_error.h"

namespace faultlab::server {
namespace {

constexpr std::chrono::milliseconds kEndRetry{500};

std::string DiagnosisText(const core::Diagnosis& diagnosis,
                          const core::DiagnosisOptions& options,
                          std::int64_t samples) {
  boost::json::object object = ToJson(diagnosis, *options.bench);
  object["samples"] = samples;
  object["period_s"] = options.period_s;
  return boost::json::serialize(object);
}

}  // namespace

void Run::Complete(core::Diagnosis& diagnosis) {
  if (!services_.complete) return;
  auto samples = services_.store.LoadSamples(id_);
  while (!samples.ok() && MayPass(samples.error())) {
    if (!services_.recorder.WaitToTryAgain(kEndRetry)) break;
    samples = services_.store.LoadSamples(id_);
  }
  if (!samples.ok()) return;  // Drain has reported it already
  services_.complete(samples.value(), request_.diagnosis, diagnosis);
}

/// Without them a repair of the diagnosis would learn from the first stretch.
void Run::StoreOptions() {
  const core::Status stored = services_.store.ReplaceOptions(id_, OptionsText(request_.diagnosis));
  if (!stored.ok()) services_.log("run " + id_ + ": its options: " + stored.error().message);
}

/// Tries again until it is stored, or can never be, or the process ends: a run that has ended and
/// is stored as running could be neither stopped nor deleted. An earlier try may have been stored.
core::Status Run::StoreEnd(const RunEnd& end, const std::string& text, core::VerdictKind verdict) {
  const std::string word(core::Name(verdict));
  for (bool kept = false;; kept = true) {
    const core::Status stored = services_.store.Finish(id_, end.state, end.at, text, word);
    if (stored.ok()) return stored;
    if (stored.error().code == core::ErrorCode::kConflict) {
      const auto record = services_.store.Get(id_);
      if (record.ok() && record.value().state == end.state) return core::Done{};
      if (record.ok()) return stored;
    }
    if (stored.error().code == core::ErrorCode::kNotFound) return stored;
    if (!kept) {
      services_.recorder.KeepEnd(id_, end);
      services_.log("run " + id_ + ": its end is not stored yet: " + stored.error().message);
    }
    if (!services_.recorder.WaitToTryAgain(kEndRetry)) return stored;
  }
}

RunState Run::EndState() const {
  if (!failure_.empty()) return RunState::kFailed;
  if (finished_) return RunState::kFinished;
  return stopped_by_us_ ? RunState::kStopped : RunState::kFailed;
}

void Run::Finish() {
  FlushRows();
  TellChanges();
  PublishReadout();
  if (auto result = box_->Take()) pipeline_.Accept(std::move(*result));
  box_.reset();
  core::Diagnosis diagnosis = request_.witness ? pipeline_.Snapshot() : pipeline_.Finish();
  FollowVerdict();
  verdict_text_ = VerdictText(diagnosis.verdict);

  FlushRecording(true);
  const WallTime ended_at = services_.clock.Wall();
  const core::Status recorded = services_.recorder.Drain(id_, {EndState(), ended_at});
  const bool left = !recorded.ok() && recorded.error().reason == kDatabaseAway;
  if (!recorded.ok() && !left) Fail(recorded.error().message);
  if (!left && !request_.witness) Complete(diagnosis);
  RunState state = EndState();
  const std::int64_t samples = Snapshot().samples;
  if (request_.witness) {
    request_.witness->OnEnd({.state = state,
                             .tripped = tripped_,
                             .by_owner = stopped_by_owner_,
                             .by_another = stopped_by_another_,
                             .revoked = revoked_,
                             .length_s = static_cast<double>(samples) * state_.period_s});
  }
  const std::string text = DiagnosisText(diagnosis, request_.diagnosis, samples);
  if (learnt_again_ && !left) StoreOptions();
  const core::Status stored =
      left ? recorded : StoreEnd({state, ended_at}, text, diagnosis.verdict.kind);
  if (!stored.ok()) {
    services_.log("run " + id_ + ": its end is not stored: " + stored.error().message);
    if (!left) state = RunState::kFailed;
  }
  const bool is_final = stored.ok() || stored.error().code == core::ErrorCode::kConflict ||
                        stored.error().code == core::ErrorCode::kNotFound;
  if (is_final) services_.recorder.Forget(id_);
  const hardware::RigDescription& rig = rig_->description();
  // A fault inside the stretch would become part of the calibration of the healthy rig, and a
  // hidden fault could be read from that calibration.
  const bool learnt_from_healthy =
      !request_.hidden_faults &&
      std::ranges::all_of(request_.plan.faults, [this](const core::Fault& fault) {
        return fault.at_s >= request_.diagnosis.healthy_to_s;
      });
  if (services_.calibrated && stored.ok() && diagnosis.calibration && learnt_from_healthy &&
      !request_.diagnosis.calibration && rig.kind != hardware::RigKind::kReplay) {
    const std::span<const double> uc_v(request_.plan.uc_v);
    const auto at = [&](double t_s) {
      const auto index =
          static_cast<std::size_t>(std::lround(std::max(t_s, 0.0) / state_.period_s));
      return std::min(index, uc_v.size());
    };
    const std::size_t from = at(request_.diagnosis.healthy_from_s);
    const std::size_t to = std::max(at(request_.diagnosis.healthy_to_s), from);
    services_.calibrated({rig.id,
                          id_,
                          request_.owner,
                          uc_v.subspan(from, to - from),
                          *request_.diagnosis.bench,
                          *diagnosis.calibration});
  }
  {
    const std::lock_guard lock(mutex_);
    state_.state = state;
    state_.verdict = core::Name(diagnosis.verdict.kind);
    state_.diagnosis_json = text;
    found_ = std::make_shared<const core::Diagnosis>(std::move(diagnosis));
    state_.diagnosis = found_;
  }
  services_.counters->solver_tasks += solver_tasks_;
  ++services_.counters->ended[static_cast<std::size_t>(state)];
  std::string last = WithStory(verdict_text_);
  const std::string hello = Hello();
  services_.hub.PublishText(id_, std::move(last), hello);
  services_.hub.CloseChannel(id_, EndText(state), hello);
}

}  // namespace faultlab::server

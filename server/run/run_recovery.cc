#include "server/run/run_recovery.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <span>
#include <utility>
#include <variant>

#include "server/run/run_messages.h"

namespace faultlab::server {
namespace {

using hardware::RigEventKind;

std::size_t SamplesPerChunk(double period_s) {
  return static_cast<std::size_t>(std::max(1L, std::lround(1.0 / period_s)));
}

}  // namespace

RunRecovery::RunRecovery(std::shared_ptr<hardware::Rig> rig,
                         RecordingStore& store,
                         RunRecord record)
    : rig_(std::move(rig)), store_(store), record_(std::move(record)) {}

core::Status RunRecovery::Begin() {
  TRY(const auto samples, store_.LoadSamples(record_.id));
  TRY(const auto events, store_.LoadEvents(record_.id));
  if (!samples.empty()) next_index_ = samples.back().index + 1;
  first_index_ = next_index_;
  for (const RecordedEvent& event : events) {
    stored_events_.insert(event.json);
    end_stored_ = end_stored_ || event.kind == Name(RigEventKind::kFinished) ||
                  event.kind == Name(RigEventKind::kStopped);
  }
  return rig_->Resume(record_.kept_run);
}

void RunRecovery::Take(const core::Sample& sample) {
  if (sample.index < next_index_) return;
  if (std::exchange(hole_, false) && sample.index > next_index_) {
    const hardware::RigEvent gap{.kind = RigEventKind::kGap,
                                 .index = next_index_,
                                 .value = static_cast<double>(sample.index - next_index_),
                                 .text = "no longer in the agent's ring"};
    events_.push_back(MakeEvent(gap, record_.period_s));
  }
  next_index_ = sample.index + 1;
  ++fetched_;
  samples_.push_back(sample);
}

void RunRecovery::Take(const hardware::RigEvent& event) {
  RecordedEvent recorded = MakeEvent(event, record_.period_s);
  const bool end = event.kind == RigEventKind::kFinished || event.kind == RigEventKind::kStopped;
  const auto stored = stored_events_.find(recorded.json);
  if (stored != stored_events_.end()) {
    stored_events_.erase(stored);
  } else if (event.kind == RigEventKind::kGap) {
    hole_ = true;                     // of what may be stored here: the next sample tells
  } else if (!end || !end_stored_) {  // the stored one has the loop's quality, too
    events_.push_back(std::move(recorded));
  }
  if (event.kind == RigEventKind::kTrip) end_ = RunState::kFailed;
  if (event.kind == RigEventKind::kFinished) end_ = RunState::kFinished;
}

core::Status RunRecovery::Write() {
  const std::size_t chunk = SamplesPerChunk(record_.period_s);
  std::size_t written = 0;
  core::Status status = core::Done{};
  while (status.ok() &&
         (samples_.size() - written >= chunk || (read_ && written < samples_.size()))) {
    const std::size_t size = std::min(chunk, samples_.size() - written);
    status = store_.AppendRecovered(record_.id, std::span(samples_).subspan(written, size));
    if (status.ok()) written += size;
  }
  samples_.erase(samples_.begin(), samples_.begin() + static_cast<std::ptrdiff_t>(written));
  return status;
}

core::Result<bool> RunRecovery::Step() {
  if (!read_) {
    std::vector<hardware::RigMessage> messages;
    read_ = rig_->Read(messages, std::chrono::milliseconds(0)) == hardware::ReadStatus::kEnded;
    for (const hardware::RigMessage& message : messages) {
      std::visit([this](const auto& each) { Take(each); }, message);
    }
    if (read_ && fetched_ > 0)
      events_.push_back(MakeRestEvent(first_index_, fetched_, record_.period_s));
  }
  TRY_DONE(Write());
  if (!read_) return false;
  TRY_DONE(store_.EndRecovery(record_.id, end_, events_));
  return true;
}

}  // namespace faultlab::server

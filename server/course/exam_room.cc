#include "server/course/exam_room.h"

#include <mutex>
#include <set>
#include <string>
#include <utility>

#include "server/course/grade.h"
#include "server/storage/chunk_codec.h"

namespace faultlab::server::course {
namespace {

/// Of a search.
constexpr double kNsOfShort = 1e9;
/// To open a run takes a diagnosis.
constexpr int kOpenedAtOnce = 4;

}  // namespace

core::Result<std::vector<std::int64_t>> ExamRoom::TrialsOf(std::span<const core::Sample> brought) {
  TRY_DONE(CatchUp());
  core::RecordIndex::Found found;
  {
    const std::shared_lock lock(mutex_);
    found = index_.Find(brought, kNsOfShort);
    if (found.samples_most) {
      TRY(const auto turn, long_search_.ForSamples(1, LongTurn::For::kPerson));
      found = index_.Find(brought);
    }
  }
  if (found.samples_most) {
    return core::Refuse("exam_compares_less", "", {{"most", *found.samples_most}});
  }
  std::vector<std::int64_t> sealed;
  for (const core::RecordIndex::Copy& copy : found.copies) {
    TRY(const auto now, parts_.blind_trials.IsSealedNow(copy.id));  // it may be due by now
    if (now) sealed.push_back(copy.id);
  }
  return sealed;
}

core::Status ExamRoom::CatchUp() {
  const std::lock_guard lock(catching_up_);
  TRY(const auto sealed, parts_.trials.SealedNow(parts_.clock.Wall()));
  std::map<std::int64_t, Assignment> assignments;
  std::set<std::int64_t> ids;
  int opened = 0;
  for (const Trials::Sealed& each : sealed) {
    if (opened < kOpenedAtOnce && IsOpened(each, assignments)) {
      ++opened;
      continue;
    }
    ids.insert(each.id);
    TRY_DONE(CatchUpOn(each));
  }
  std::erase_if(known_, [&](const auto& each) {
    if (ids.contains(each.first)) return false;
    const std::unique_lock writing(mutex_);
    index_.Remove(each.first);
    return true;
  });
  return core::Done{};
}

bool ExamRoom::IsOpened(const Trials::Sealed& trial,
                        std::map<std::int64_t, Assignment>& assignments) {
  if (!assignments.contains(trial.assignment)) {
    auto found = parts_.assignments.Get(trial.assignment);
    if (!found) return false;
    assignments.emplace(trial.assignment, std::move(found).value());
  }
  const WallTime closes = BlindTrials::ClosesFor(assignments.at(trial.assignment), trial.account);
  if (parts_.clock.Wall() < closes) return false;
  const auto sealed = parts_.blind_trials.IsSealedNow(trial.id);
  if (!sealed) parts_.log("trial " + std::to_string(trial.id) + ": " + sealed.error().message);
  return sealed.ok() && !sealed.value();
}

core::Status ExamRoom::CatchUpOn(const Trials::Sealed& trial) {
  Known& known = known_[trial.id];
  if (known.whole) return core::Done{};
  const auto record = parts_.store.Get(trial.run);
  if (!record) {
    const bool gone = record.error().code == core::ErrorCode::kNotFound;
    return gone ? core::Status(core::Done{}) : record.error();
  }
  if (record.value().samples > known.samples) {
    const auto samples = parts_.store.LoadSamples(trial.run);
    if (!samples && samples.error().reason != kRecordingDamaged) return samples.error();
    if (!samples) parts_.log("trial " + std::to_string(trial.id) + ": " + samples.error().message);
    if (samples) {
      core::RecordIndex::Entry entry = core::RecordIndex::Prepare(samples.value());
      const std::unique_lock writing(mutex_);
      index_.Put(trial.id, std::move(entry));
    }
    known.samples = record.value().samples;
  }
  known.whole = record.value().state != RunState::kRunning && !record.value().AwaitsRecovery();
  return core::Done{};
}

core::Status ExamRoom::MayBring(const Principal& who) {
  if (who.user_id == 0) return core::Done{};
  const WallTime now = parts_.clock.Wall();
  constexpr int kPage = 100;
  std::int64_t after = 0;
  while (true) {
    TRY(const auto page, parts_.assignments.List(who.user_id, after, kPage));
    for (const Assignment& each : page) {
      after = each.id;
      const WallTime closes = BlindTrials::ClosesFor(each, who.user_id);
      if (now < each.opens || now >= closes) continue;
      const auto rubric = ParseRubric(each.rubric_json);
      if (!rubric || !rubric.value().uploads_wait) continue;
      TRY(const auto teaches, parts_.accounts.Teaches(who.user_id, each.course));
      if (teaches) continue;
      return core::Refuse("uploads_wait", "", {{"assignment", each.name}});
    }
    if (page.size() < static_cast<std::size_t>(kPage)) return core::Done{};
  }
}

}  // namespace faultlab::server::course

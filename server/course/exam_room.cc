#include "server/course/exam_room.h"

#include <mutex>
#include <set>

#include "server/course/grade.h"

namespace faultlab::server::course {

core::Result<std::int64_t> ExamRoom::TrialOf(std::span<const core::Sample> brought) {
  const core::Status caught = CatchUp();
  if (!caught.ok()) return caught.error();
  std::int64_t id = 0;
  {
    const std::shared_lock lock(mutex_);
    const auto copy = index_.Find(brought);
    if (!copy) return 0;
    id = copy->id;
  }
  const core::Status looked = parts_.blind_trials.Look(id);  // it may be due by now
  if (!looked.ok()) return looked.error();
  const auto trial = parts_.trials.Get(id);
  if (!trial) return trial.error();
  return trial.value().released_at ? 0 : id;
}

core::Status ExamRoom::CatchUp() {
  const auto sealed = parts_.trials.SealedNow(parts_.clock.Wall());
  if (!sealed) return sealed.error();
  const std::unique_lock lock(mutex_);
  std::set<std::int64_t> ids;
  for (const Trials::Sealed& each : sealed.value()) {
    ids.insert(each.id);
    Known& known = known_[each.id];
    if (known.whole) continue;
    const auto record = parts_.store.Get(each.run);
    if (!record && record.error().code == core::ErrorCode::kNotFound) continue;
    if (!record) return record.error();
    if (record.value().samples > known.samples) {
      const auto samples = parts_.store.LoadSamples(each.run);
      if (!samples) return samples.error();
      index_.Put(each.id, samples.value());
      known.samples = static_cast<std::int64_t>(samples.value().size());
    }
    known.whole = record.value().state != RunState::kRunning && !record.value().AwaitsRecovery();
  }
  std::erase_if(known_, [&](const auto& each) {
    if (ids.contains(each.first)) return false;
    index_.Remove(each.first);
    return true;
  });
  return core::Done{};
}

core::Status ExamRoom::MayBring(const Principal& who) {
  if (who.user_id == 0) return core::Done{};
  const WallTime now = parts_.clock.Wall();
  constexpr int kPage = 100;
  std::int64_t after = 0;
  while (true) {
    const auto page = parts_.assignments.List(who.user_id, after, kPage);
    if (!page) return page.error();
    for (const Assignment& each : page.value()) {
      after = each.id;
      const WallTime closes = BlindTrials::ClosesFor(each, who.user_id);
      if (now < each.opens || now >= closes) continue;
      const auto rubric = ParseRubric(each.rubric_json);
      if (!rubric || !rubric.value().uploads_wait) continue;
      const auto teaches = parts_.accounts.Teaches(who.user_id, each.course);
      if (!teaches) return teaches.error();
      if (teaches.value()) continue;
      return core::Error{core::ErrorCode::kConflict,
                         "The exercise '" + each.name +
                             "' is open, and its teacher lets uploads wait until it is due.",
                         "",
                         "uploads_wait",
                         {{"assignment", each.name}}};
    }
    if (page.value().size() < static_cast<std::size_t>(kPage)) return core::Done{};
  }
}

}  // namespace faultlab::server::course

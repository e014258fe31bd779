#include "server/story/run_story.h"

#include <algorithm>
#include <boost/json.hpp>
#include <cmath>
#include <map>
#include <string_view>
#include <utility>

namespace faultlab::server {
namespace {

/// Times that went through JSON are equal within this.
constexpr double kSameS = 1e-6;

bool Near(double one_s, double other_s) {
  return std::abs(one_s - other_s) <= kSameS;
}

bool IsNominal(core::Component component, double value) {
  constexpr double kRelative = 1e-6;  // of numbers that went through JSON
  const double nominal = component.info().nominal;
  return std::abs(value - nominal) <= kRelative * std::max(std::abs(value), std::abs(nominal));
}

/// Follows a run event by event, then what was found.
class Teller {
 public:
  explicit Teller(double period_s) : period_s_(period_s) {}

  void Hear(const StoryEvent& event) {
    const double at_s = static_cast<double>(event.index) * period_s_;
    switch (event.kind) {
      case StoryEvent::Kind::kCommanded:
        commanded_s_.try_emplace(event.component, at_s);
        break;
      case StoryEvent::Kind::kConfirmed:
        Change(event.component, event.value, at_s);
        break;
      case StoryEvent::Kind::kTrip:  // an interlock sets all components back to nominal
        for (const core::Component component : Faulty()) {
          Change(component, component.info().nominal, at_s);
        }
        break;
      case StoryEvent::Kind::kDetected:
        Detect(at_s);
        break;
      case StoryEvent::Kind::kIsolated:
        Isolate(at_s);
        break;
      case StoryEvent::Kind::kReturned:
      case StoryEvent::Kind::kLearning:  // the diagnosis begins anew
        End(at_s);
        break;
    }
  }

  /// It belongs to the episode in which it was detected.
  void Find(const core::FaultEpisode& found) {
    const core::Verdict& verdict = found.verdict;
    const std::optional<double> at_s =
        verdict.detected_at_s ? verdict.detected_at_s : verdict.onset_s;
    if (!at_s) return;
    const auto holds = [&](const StoryEpisode& each) {
      const bool is_its_time =
          each.onset_s <= *at_s + kSameS && (!each.ended_s || *at_s < *each.ended_s - kSameS);
      return is_its_time || FindDetection(each, *at_s) != nullptr;
    };
    const auto last = std::find_if(story_.episodes.rbegin(), story_.episodes.rend(), holds);
    if (last != story_.episodes.rend()) {
      const StoryDetection* alarm = FindDetection(*last, *at_s);
      if (alarm != nullptr && alarm->of == StoryDetection::Of::kReturn) return;
    }
    StoryEpisode& episode =
        last != story_.episodes.rend() ? *last : Add(verdict.onset_s.value_or(*at_s));
    episode.found = found;
    if (episode.changes.empty()) episode.onset_s = verdict.onset_s.value_or(*at_s);
    if (episode.detections.empty()) {
      AddDetection(episode, *at_s);
      for (const core::Detection& again : verdict.further) {
        AddDetection(episode, again.detected_at_s);
      }
    }
    if (!episode.ended_s) episode.ended_s = found.ended_at_s;
    std::ranges::stable_sort(story_.episodes, {}, &StoryEpisode::onset_s);
  }

  RunStory Story() && { return std::move(story_); }

 private:
  struct Position {
    core::Component component;
    double value = 0.0;
  };

  static const StoryDetection* FindDetection(const StoryEpisode& episode, double at_s) {
    const auto found = std::ranges::find_if(
        episode.detections, [&](const StoryDetection& each) { return Near(each.at_s, at_s); });
    return found == episode.detections.end() ? nullptr : &*found;
  }

  void Change(core::Component component, double value, double at_s) {
    const auto commanded = commanded_s_.find(component);
    const double since_s = commanded == commanded_s_.end() ? at_s : commanded->second;
    if (commanded != commanded_s_.end()) commanded_s_.erase(commanded);
    const auto known = std::ranges::find(positions_, component, &Position::component);
    const double before = known == positions_.end() ? component.info().nominal : known->value;
    RigChange change{at_s, component, value, before, IsNominal(component, value), {}};
    for (const core::Component other : Faulty()) {
      if (other != component) change.others.push_back(other);
    }
    if (known == positions_.end()) {
      positions_.push_back({component, value});
    } else {
      known->value = value;
    }
    if (change.nominal && IsNominal(component, before)) return;  // it was and stays healthy
    story_.changes.push_back(change);
    StoryEpisode& episode = EpisodeOf(component, since_s, at_s);
    if (change.nominal) episode.ended_s = at_s;
    episode.changes.push_back(std::move(change));
  }

  /// Of a change: its component's own, or one of which only an alarm is known: a sample before the
  /// rig's report, or while a part drifts, which is confirmed when it has come to its end.
  StoryEpisode& EpisodeOf(core::Component component, double since_s, double at_s) {
    const auto own = std::find_if(
        story_.episodes.rbegin(), story_.episodes.rend(), [&](const StoryEpisode& each) {
          return !each.ended_s && !each.changes.empty() &&
                 each.changes.back().component == component;
        });
    if (own != story_.episodes.rend()) return *own;
    if (!story_.episodes.empty()) {
      StoryEpisode& last = story_.episodes.back();
      const double about_s = 2.0 * period_s_;
      const bool unreported = !last.ended_s && last.changes.empty();
      if (unreported && last.onset_s >= since_s - about_s && last.onset_s <= at_s + about_s) {
        return last;
      }
    }
    return Add(at_s);
  }

  void Detect(double at_s) { AddDetection(Expects() ? story_.episodes.back() : Add(at_s), at_s); }

  /// Whether an alarm now is of the newest episode: it goes on, or its return was not noticed yet.
  bool Expects() const {
    if (story_.episodes.empty()) return false;
    const StoryEpisode& last = story_.episodes.back();
    if (!last.ended_s) return true;
    const bool returned =
        std::ranges::find(last.detections, StoryDetection::Of::kReturn, &StoryDetection::of) !=
        last.detections.end();
    return !last.changes.empty() && !returned;
  }

  void AddDetection(StoryEpisode& episode, double at_s) {
    using Of = StoryDetection::Of;
    const auto cause =
        std::find_if(episode.changes.rbegin(), episode.changes.rend(), [&](const RigChange& each) {
          return each.at_s <= at_s + kSameS;
        });
    StoryDetection detection{.at_s = at_s, .delay_s = {}, .isolated_s = {}};
    detection.of = episode.detections.empty() ? Of::kFirst : Of::kFurther;
    if (cause != episode.changes.rend()) {
      detection.delay_s = at_s - cause->at_s;
      if (cause->nominal) detection.of = Of::kReturn;
    }
    episode.detections.push_back(detection);
  }

  void Isolate(double at_s) {
    if (story_.episodes.empty() || story_.episodes.back().detections.empty()) return;
    StoryDetection& newest = story_.episodes.back().detections.back();
    if (!newest.isolated_s) newest.isolated_s = at_s;
  }

  /// A return is told late: what was changed since, and has raised no alarm yet, goes on.
  void End(double at_s) {
    const auto last = std::find_if(
        story_.episodes.rbegin(), story_.episodes.rend(), [](const StoryEpisode& each) {
          return !each.detections.empty();
        });
    if (last != story_.episodes.rend() && !last->ended_s) last->ended_s = at_s;
  }

  StoryEpisode& Add(double onset_s) {
    StoryEpisode& episode = story_.episodes.emplace_back();
    episode.onset_s = onset_s;
    return episode;
  }

  std::vector<core::Component> Faulty() const {
    std::vector<core::Component> faulty;
    for (const Position& each : positions_) {
      if (!IsNominal(each.component, each.value)) faulty.push_back(each.component);
    }
    return faulty;
  }

  const double period_s_;
  RunStory story_;
  std::vector<Position> positions_;
  std::map<core::Component, double, core::ByIndex> commanded_s_;
};

}  // namespace

double StoryEpisode::since_s() const {
  if (!found) return onset_s;
  return core::NewestChange(found->verdict).value_or(onset_s);
}

std::vector<double> RunStory::ChangeTimes() const {
  std::vector<double> times;
  for (const RigChange& change : changes) times.push_back(change.at_s);
  for (const StoryEpisode& each : episodes) {
    if (!each.changes.empty()) continue;
    times.push_back(each.onset_s);
    if (!each.found) continue;
    for (const core::Detection& one : each.found->verdict.further) {
      times.push_back(one.onset_s.value_or(one.detected_at_s));
    }
  }
  std::ranges::sort(times);
  times.erase(std::unique(times.begin(), times.end()), times.end());
  return times;
}

std::vector<core::FaultEpisode> RunStory::Found() const {
  std::vector<core::FaultEpisode> found;
  for (const StoryEpisode& each : episodes) {
    if (each.found) found.push_back(*each.found);
  }
  return found;
}

std::optional<StoryEvent> ToStoryEvent(const RecordedEvent& recorded, const core::Bench& bench) {
  using Kind = StoryEvent::Kind;
  const auto kind = std::ranges::find(kStoryEventKinds, recorded.kind);
  if (kind == kStoryEventKinds.end()) return std::nullopt;
  StoryEvent event{.kind = static_cast<Kind>(kind - kStoryEventKinds.begin()),
                   .index = recorded.index};
  if (event.kind != Kind::kCommanded && event.kind != Kind::kConfirmed) return event;
  boost::system::error_code ec;
  const boost::json::value parsed = boost::json::parse(recorded.json, ec);
  const boost::json::object* object = ec ? nullptr : parsed.if_object();
  if (object == nullptr) return std::nullopt;
  const boost::json::value* name = object->if_contains("component");
  const boost::json::value* value = object->if_contains("value");
  if (name == nullptr || !name->is_string()) return std::nullopt;
  const auto component = bench.Find(std::string_view(name->get_string()));
  if (!component) return std::nullopt;
  event.component = *component;
  if (value != nullptr && value->is_number()) event.value = value->to_number<double>();
  return event;
}

RunStory TellStory(std::vector<StoryEvent> events,
                   const core::Diagnosis& diagnosis,
                   double period_s) {
  std::ranges::stable_sort(events, {}, &StoryEvent::index);  // an alarm is told late
  Teller teller(period_s);
  for (const StoryEvent& event : events) teller.Hear(event);
  for (const core::FaultEpisode& found : core::EpisodesOf(diagnosis)) teller.Find(found);
  return std::move(teller).Story();
}

RunStory TellStory(std::span<const RecordedEvent> events,
                   const core::Diagnosis& diagnosis,
                   const core::Bench& bench,
                   double period_s) {
  std::vector<StoryEvent> told;
  for (const RecordedEvent& each : events) {
    if (const auto event = ToStoryEvent(each, bench)) told.push_back(*event);
  }
  return TellStory(std::move(told), diagnosis, period_s);
}

std::vector<core::Fault> FaultsToShow(std::span<const RigChange> changes,
                                      std::vector<core::Fault> planned) {
  std::vector<core::Fault> drifts;
  std::ranges::copy_if(planned, std::back_inserter(drifts), [](const core::Fault& fault) {
    return fault.kind == core::FaultKind::kDrift;
  });
  std::vector<core::Fault> shown = drifts;
  for (const RigChange& change : changes) {
    const bool of_a_drift = std::ranges::any_of(drifts, [&](const core::Fault& drift) {
      return drift.component == change.component && change.at_s <= drift.until_s &&
             change.at_s >= drift.at_s;
    });
    if (of_a_drift) continue;
    shown.push_back({.component = change.component, .value = change.value, .at_s = change.at_s});
  }
  if (changes.empty()) return planned;
  std::ranges::stable_sort(shown, {}, &core::Fault::at_s);
  return shown;
}

}  // namespace faultlab::server

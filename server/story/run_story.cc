#include "server/story/run_story.h"

#include <algorithm>
#include <boost/json.hpp>
#include <cmath>
#include <map>
#include <string_view>
#include <utility>

#include "server/json/kept_json.h"

namespace faultlab::server {
namespace {

/// Times that went through JSON are equal within this.
constexpr double kSameS = 1e-6;

/// A part that is set back raises an alarm within this time, even where its fault raised none.
constexpr double kReturnSeenS = 5.0;

bool Near(double one_s, double other_s) {
  return std::abs(one_s - other_s) <= kSameS;
}

bool IsNominal(core::Component component, double value) {
  constexpr double kRelative = 1e-6;  // of numbers that went through JSON
  const double nominal = component.info().nominal;
  return std::abs(value - nominal) <= kRelative * std::max(std::abs(value), std::abs(nominal));
}

std::vector<core::Component> NamedIn(const boost::json::object& event, const core::Bench& bench) {
  std::vector<core::Component> named;
  const boost::json::value* names = event.if_contains("components");
  if (names == nullptr || !names->is_array()) return named;
  for (const boost::json::value& each : names->get_array()) {
    if (!each.is_string()) continue;
    if (const auto component = bench.Find(std::string_view(each.get_string()))) {
      named.push_back(*component);
    }
  }
  return named;
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
        Isolate(event.named, at_s);
        break;
      case StoryEvent::Kind::kReturned:
      case StoryEvent::Kind::kLearning:  // the diagnosis begins anew
        Return(at_s);
        break;
    }
  }

  /// It belongs to the episode in which it was detected.
  void Find(const core::FaultEpisode& found) {
    const core::Verdict& verdict = found.verdict;
    const std::optional<double> at_s =
        verdict.detected_at_s ? verdict.detected_at_s : verdict.onset_s;
    if (!at_s) return;
    StoryEpisode* episode = Holding(*at_s);
    if (episode != nullptr) {
      const StoryDetection* alarm = FindDetection(*episode, *at_s);
      if (alarm != nullptr && alarm->of == StoryDetection::Of::kReturn) {
        episode = StillFaulty(*episode);  // what the return has left
        if (episode == nullptr) return;
      } else if (episode->found && !Near(*episode->found->verdict.detected_at_s, *at_s)) {
        episode = &Split(*episode, *at_s);  // another fault, of which no rig has told
      }
    }
    if (episode == nullptr) episode = &Add(verdict.onset_s.value_or(*at_s));
    episode->found = found;
    if (episode->detections.empty()) {
      AddDetection(*episode, *at_s);
      for (const core::Detection& again : verdict.further) {
        AddDetection(*episode, again.detected_at_s);
      }
    }
    if (episode->changes.empty()) {
      episode->onset_s = verdict.onset_s.value_or(*at_s);
      if (!episode->ended_s) episode->ended_s = found.ended_at_s;
    }
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

  /// The newest episode that `test` is true of.
  template <typename Test>
  StoryEpisode* Newest(Test test) {
    const auto found = std::find_if(story_.episodes.rbegin(), story_.episodes.rend(), test);
    return found == story_.episodes.rend() ? nullptr : &*found;
  }

  StoryEpisode* Holding(double at_s) {
    return Newest([&](const StoryEpisode& each) {
      const bool is_its_time =
          each.onset_s <= at_s + kSameS && (!each.ended_s || at_s < *each.ended_s - kSameS);
      return is_its_time || FindDetection(each, at_s) != nullptr;
    });
  }

  /// The newest other episode that goes on, and of which a rig has told.
  StoryEpisode* StillFaulty(const StoryEpisode& but) {
    return Newest([&but](const StoryEpisode& each) {
      return &each != &but && !each.ended_s && !each.changes.empty();
    });
  }

  /// The alarms from `at_s` on are of an episode of their own.
  StoryEpisode& Split(StoryEpisode& episode, double at_s) {
    const auto from = std::ranges::find_if(
        episode.detections, [&](const StoryDetection& each) { return each.at_s >= at_s - kSameS; });
    std::vector<StoryDetection> moved(from, episode.detections.end());
    episode.detections.erase(from, episode.detections.end());
    if (episode.changes.empty() && !episode.ended_s) episode.ended_s = at_s;
    StoryEpisode& own = Add(at_s);
    for (StoryDetection& each : moved) {
      each.of = own.detections.empty() ? StoryDetection::Of::kFirst : StoryDetection::Of::kFurther;
      each.delay_s.reset();
      own.detections.push_back(std::move(each));
    }
    return own;
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
    StoryEpisode* own = Newest([&](const StoryEpisode& each) {
      return !each.ended_s && !each.changes.empty() && each.changes.back().component == component;
    });
    if (own != nullptr) return *own;
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

  void Detect(double at_s) {
    AddDetection(Expects(at_s) ? story_.episodes.back() : Add(at_s), at_s);
  }

  /// Whether an alarm now is of the newest episode: it goes on, or its return was not noticed yet.
  bool Expects(double at_s) const {
    if (story_.episodes.empty()) return false;
    const StoryEpisode& last = story_.episodes.back();
    if (!last.ended_s) return true;
    const bool returned =
        returned_ == story_.episodes.size() ||
        std::ranges::find(last.detections, StoryDetection::Of::kReturn, &StoryDetection::of) !=
            last.detections.end();
    if (last.changes.empty() || returned) return false;
    return !last.detections.empty() || at_s <= last.changes.back().at_s + kReturnSeenS;
  }

  void AddDetection(StoryEpisode& episode, double at_s) {
    using Of = StoryDetection::Of;
    const auto cause =
        std::find_if(episode.changes.rbegin(), episode.changes.rend(), [&](const RigChange& each) {
          return each.at_s <= at_s + kSameS;
        });
    StoryDetection detection;
    detection.at_s = at_s;
    detection.of = episode.detections.empty() ? Of::kFirst : Of::kFurther;
    if (cause != episode.changes.rend()) {
      detection.delay_s = at_s - cause->at_s;
      if (cause->nominal) detection.of = Of::kReturn;
    }
    episode.detections.push_back(detection);
  }

  /// What is told late is of the newest alarm, also when something was changed since that has
  /// raised none yet.
  StoryEpisode* NewestDetected() {
    return Newest([](const StoryEpisode& each) { return !each.detections.empty(); });
  }

  void Isolate(const std::vector<core::Component>& named, double at_s) {
    StoryEpisode* episode = NewestDetected();
    if (episode == nullptr) return;
    StoryDetection& newest = episode->detections.back();
    if (!newest.isolated_s) newest.isolated_s = at_s;
    newest.named = named;
  }

  /// The diagnosis finds the rig healthy. What the rig says not to be so goes on all the same.
  void Return(double at_s) {
    StoryEpisode* episode = NewestDetected();
    if (episode == nullptr) return;
    if (episode == &story_.episodes.back()) returned_ = story_.episodes.size();
    const bool still_faulty = !episode->changes.empty() && !episode->changes.back().nominal;
    if (!episode->ended_s && !still_faulty) episode->ended_s = at_s;
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
  std::size_t returned_ = 0;  ///< of so many episodes the last one has returned
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
  const bool tells = event.kind == Kind::kCommanded || event.kind == Kind::kConfirmed;
  if (!tells && event.kind != Kind::kIsolated) return event;
  const boost::json::value parsed = ParsedOr(recorded.json);
  const boost::json::object* object = parsed.if_object();
  if (object == nullptr) return std::nullopt;
  if (!tells) {
    event.named = NamedIn(*object, bench);
    return event;
  }
  const auto component = bench.Find(TextIn(parsed, "component"));
  if (!component) return std::nullopt;
  event.component = *component;
  const boost::json::value* value = object->if_contains("value");
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
  RunStory story = std::move(teller).Story();
  story.set_back = diagnosis.verdict.kind == core::VerdictKind::kNominal && !story.Found().empty();
  return story;
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

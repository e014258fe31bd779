#include <algorithm>
#include <cctype>
#include <string>
#include <vector>

#include "server/report/report_section.h"
#include "server/report/sentences.h"

namespace faultlab::server {
namespace {

constexpr std::size_t kEpisodesShown = 6;

class VerdictSection : ReportSection {
 public:
  VerdictSection(const RunReport& report, const ReportWords& words)
      : ReportSection(report, words) {}

  void Write(PdfDocument& paper) const {
    const core::Verdict& verdict = report_.diagnosis.verdict;
    paper.Heading(words_.verdict);
    paper.Paragraph(Headline(), PdfDocument::Tone::kStrong);
    if (verdict.kind == core::VerdictKind::kFault) {
      const std::vector<core::Component> named = core::NamedBy(verdict);
      for (const core::Component component : named) {
        const auto found =
            std::ranges::find(verdict.candidates, component, &core::Candidate::component);
        if (found != verdict.candidates.end()) {
          paper.Fact(std::string(core::Name(component)), Sized(*found));
        }
      }
      const auto runner_up = std::ranges::find_if(verdict.candidates, [&](const auto& one) {
        return std::ranges::find(named, one.component) == named.end();
      });
      if (named.size() > 1) paper.Paragraph(words_.group);
      if (!verdict.candidates.empty()) {
        paper.Fact(words_.certainty,
                   Fill(words_.explains, {Digits(verdict.candidates.front().score, 3)}));
      }
      if (verdict.response) Response(paper, *verdict.response);
      if (runner_up != verdict.candidates.end()) {
        paper.Fact(words_.runner_up,
                   Fill(words_.runner_up_is,
                        {Stated(*runner_up),
                         Factor(runner_up->score / verdict.candidates.front().score, 2)}));
      }
    }
    std::string label = words_.detected;
    for (const core::Detection& one : core::DetectionsOf(verdict)) {
      paper.Fact(label, DetectedText(one));
      label = words_.detected_again;
    }
    Earlier(paper);
    const bool usual = verdict.reason.find("warms up") == std::string::npos;
    const bool explained = verdict.kind == core::VerdictKind::kFault ||
                           (verdict.kind == core::VerdictKind::kNominal && usual);
    if (!explained && !verdict.reason.empty()) paper.Paragraph(ReasonIn(words_, verdict.reason));
    const bool concluded = verdict.kind == core::VerdictKind::kFault ||
                           verdict.kind == core::VerdictKind::kUnknownFault;
    if (concluded && !verdict.settled) paper.Paragraph(words_.unsettled);
  }

 private:
  /// What happened: of a rig that is healthy again, what it had.
  std::string Headline() const {
    if (report_.sealed) return words_.sealed;
    if (!report_.story.set_back) return VerdictText(report_.diagnosis.verdict);
    std::string had;
    for (const core::FaultEpisode& each : report_.story.Found()) {
      had += (had.empty() ? "" : "; ") + VerdictText(each.verdict);
    }
    return Fill(words_.verdict_set_back, {had});
  }

  std::string VerdictText(const core::Verdict& verdict) const {
    switch (verdict.kind) {
      case core::VerdictKind::kFault:
        return Fill(words_.verdict_fault,
                    {Joined(core::NamedBy(verdict), words_.or_word) + Arrow(verdict)}) +
               Beside(verdict);
      case core::VerdictKind::kUnknownFault:
        return core::IsOutside(verdict) ? Outside(verdict) : words_.verdict_unknown;
      case core::VerdictKind::kNominal:
        return words_.verdict_nominal;
      case core::VerdictKind::kNotExcited:
        return words_.verdict_not_excited;
      case core::VerdictKind::kCalibrating:
        break;
    }
    return words_.verdict_none;
  }

  /// What is no component.
  std::string Outside(const core::Verdict& verdict) const {
    return verdict.friction ? words_.verdict_friction
                            : Fill(words_.verdict_sensor, {verdict.sensor->channel});
  }

  /// Of a fault beside which it is not excluded.
  std::string Beside(const core::Verdict& verdict) const {
    if (!verdict.friction && !verdict.sensor) return "";
    std::string outside = Outside(verdict);
    outside.front() = static_cast<char>(std::tolower(outside.front()));
    return " " + words_.or_word + " " + outside;
  }

  /// Of one component: whether its value is larger or smaller than the nominal one.
  static const char* Arrow(const core::Verdict& verdict) {
    if (verdict.candidates.empty() || core::NamedBy(verdict).size() != 1) return "";
    const core::Candidate& best = verdict.candidates.front();
    return best.value >= best.component.info().nominal ? " ↑" : " ↓";
  }

  std::string Sized(const core::Candidate& candidate) const {
    const std::string value = ValueOf(candidate.component, candidate.value);
    const std::string nominal = ValueOf(candidate.component, candidate.component.info().nominal);
    if (candidate.bound != 0) {
      return Fill(words_.bound, {std::string(1, candidate.bound) + " " + value, nominal});
    }
    return Fill(words_.standard_error, {SizeOf(candidate), nominal});
  }

  std::string SizeOf(const core::Candidate& candidate) const {
    return WithError(candidate.value, candidate.sigma, core::Unit(candidate.component));
  }

  /// "R9 = 33.0 ± 0.2 kΩ", or "C8 > 5 mF" where only a bound is known.
  std::string Stated(const core::Candidate& candidate) const {
    const std::string name(core::Name(candidate.component));
    if (candidate.bound == 0) return name + " = " + SizeOf(candidate);
    return name + " " + candidate.bound + " " + ValueOf(candidate.component, candidate.value);
  }

  /// "R9 = 33.0 ± 0.2 kΩ or R12 = 5.82 ± 0.04 kΩ": what looks alike.
  std::string StatedAll(const core::Verdict& verdict) const {
    std::string all;
    for (const core::Component component : core::NamedBy(verdict)) {
      const auto found =
          std::ranges::find(verdict.candidates, component, &core::Candidate::component);
      if (!all.empty()) all += " " + words_.or_word + " ";
      all +=
          found == verdict.candidates.end() ? std::string(core::Name(component)) : Stated(*found);
    }
    return all;
  }

  /// "the residual test" of "residual", as the page calls it.
  std::string Detector(const std::string& name) const {
    if (name == "residual") return words_.detector_residual;
    if (name == "cusum") return words_.detector_cusum;
    const std::string_view glr = "glr_";
    if (name.starts_with(glr)) return Fill(words_.detector_glr, {name.substr(glr.size())});
    return name;
  }

  std::string DetectedText(const core::Detection& one) const {
    std::string text =
        Fill(words_.detected_at, {Fixed(one.detected_at_s, 2), Detector(one.detector)});
    if (one.onset_s) text += Fill(words_.began_at, {Fixed(*one.onset_s, 2)});
    return text;
  }

  /// What was found before the verdict, newest last: the rig may be nominal again.
  void Earlier(PdfDocument& paper) const {
    const std::vector<core::FaultEpisode> all = report_.story.Found();
    const std::size_t from = all.size() > kEpisodesShown ? all.size() - kEpisodesShown : 0;
    for (std::size_t i = from; i < all.size(); ++i) {
      const core::FaultEpisode& episode = all[i];
      if (!episode.ended_at_s || !episode.verdict.detected_at_s) continue;
      std::string said = VerdictText(episode.verdict);
      if (episode.verdict.kind == core::VerdictKind::kFault) {
        said = Fill(words_.verdict_fault, {StatedAll(episode.verdict)});
      }
      std::string times;
      for (const core::Detection& one : core::DetectionsOf(episode.verdict)) {
        times += (times.empty() ? "" : ", ") + Fixed(one.detected_at_s, 2);
      }
      paper.Fact(words_.earlier,
                 Fill(words_.earlier_is, {said, times, Fixed(*episode.ended_at_s, 2)}));
    }
  }

  /// How the motor answers, where the speed alone tells of it.
  void Response(PdfDocument& paper, const core::ResponseChange& response) const {
    const auto fact = [&](const std::string& name,
                          const core::Measured core::SpeedResponse::*number,
                          double factor,
                          std::string_view unit) {
      const auto text = [&](const core::SpeedResponse& one) {
        const core::Measured& measured = one.*number;
        return WithError(factor * measured.value, factor * measured.sigma, unit);
      };
      paper.Fact(name, Fill(words_.response_is, {text(response.after), text(response.before)}));
    };
    fact(words_.response_gain, &core::SpeedResponse::gain, 1.0, "rpm/V");
    fact(words_.response_time, &core::SpeedResponse::time_constant, kMilli, "ms");
    fact(words_.response_friction, &core::SpeedResponse::friction, 1.0, "rpm");
  }
};

}  // namespace

void WriteVerdict(const RunReport& report, const ReportWords& words, PdfDocument& paper) {
  VerdictSection(report, words).Write(paper);
}

}  // namespace faultlab::server

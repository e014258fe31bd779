#include <algorithm>
#include <string>
#include <vector>

#include "core/paper/path_outcome.h"
#include "server/report/report_section.h"
#include "server/report/sentences.h"

namespace faultlab::server {
namespace {

constexpr std::size_t kStepsShown = 6;

class PathSection : ReportSection {
 public:
  PathSection(const RunReport& report, const ReportWords& words) : ReportSection(report, words) {}

  void Write(PdfDocument& paper) const {
    const core::Verdict verdict = Told();
    if (verdict.path.empty() && report_.bench->published.source.empty()) return;
    paper.Heading(words_.path);
    if (verdict.path.empty()) {
      paper.Paragraph(report_.sealed ? words_.sealed : words_.path_none);
      return;
    }
    for (std::size_t i = 0; i < std::min(verdict.path.size(), kStepsShown); ++i) {
      const core::PathStep& step = verdict.path[i];
      std::string text = std::to_string(i + 1) + ". " +
                         Fill(words_.step,
                              {QuestionIn(words_, step.question),
                               step.answer ? words_.yes : words_.no,
                               Number(step.value),
                               Number(step.threshold)});
      if (!step.leads_to.empty()) text += Fill(words_.leads_to, {LeadsTo(step)});
      paper.Paragraph(text);
    }
    Outcome(paper);
  }

 private:
  /// The verdict; of a rig that is healthy again, the last fault that has a path.
  core::Verdict Told() const {
    const core::Verdict& verdict = report_.diagnosis.verdict;
    if (verdict.kind != core::VerdictKind::kNominal || !verdict.path.empty()) return verdict;
    const std::vector<core::FaultEpisode> all = report_.story.Found();
    const auto last = std::find_if(all.rbegin(), all.rend(), [](const core::FaultEpisode& each) {
      return !each.verdict.path.empty();
    });
    return last == all.rend() ? verdict : last->verdict;
  }

  std::string LeadsTo(const core::PathStep& step) const {
    if (!step.components.empty()) return Joined(step.components, words_.or_word);
    if (step.leads_to == "nominal") return words_.nominal;
    return step.leads_to == "no component" ? words_.no_component : step.leads_to;
  }

  void Outcome(PdfDocument& paper) const {
    using core::PathOutcome;
    const core::Verdict verdict = Told();
    std::string end =
        verdict.path.empty() ? "" : Joined(verdict.path.back().components, words_.or_word);
    const PathOutcome outcome = core::ComparePath(verdict);
    if (outcome == PathOutcome::kNothing) {
      if (!end.empty()) paper.Paragraph(Fill(words_.path_alone, {end}));
      return;
    }
    if (end.empty()) end = "–";
    if (outcome == PathOutcome::kAgrees) {
      paper.Paragraph(Fill(words_.path_agrees, {end}));
      return;
    }
    if (outcome == PathOutcome::kUnknown) {
      paper.Paragraph(Fill(words_.why_unknown, {end}), PdfDocument::Tone::kStrong);
      return;
    }
    std::string why = words_.why_window;
    if (outcome == PathOutcome::kSettling) why = words_.why_settling;
    if (outcome == PathOutcome::kClose) {
      const auto step = std::ranges::find_if(verdict.path, core::IsClose);
      why = Fill(words_.why_close, {QuestionIn(words_, step->question)});
    }
    const std::string said = Joined(core::NamedBy(verdict), words_.or_word);
    paper.Paragraph(Fill(words_.path_differs, {end, said}) + " " + why, PdfDocument::Tone::kStrong);
  }
};

}  // namespace

void WritePath(const RunReport& report, const ReportWords& words, PdfDocument& paper) {
  PathSection(report, words).Write(paper);
}

}  // namespace faultlab::server

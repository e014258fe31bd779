#include <array>
#include <string>
#include <vector>

#include "server/report/report_section.h"

namespace faultlab::server {
namespace {

constexpr std::size_t kFaultsShown = 10;

class ChangesSection : ReportSection {
 public:
  ChangesSection(const RunReport& report, const ReportWords& words)
      : ReportSection(report, words) {}

  void Faults(PdfDocument& paper) const {
    if (report_.rig.empty()) return;
    paper.Heading(words_.faults);
    if (report_.faults.empty()) {
      paper.Paragraph(report_.sealed ? words_.sealed : words_.faults_none);
      return;
    }
    const std::array<PdfDocument::Column, 5> columns = {{{words_.at_time, 22, true},
                                                         {words_.at_sample, 22, true},
                                                         {words_.component, 32, false},
                                                         {words_.value, 50, false},
                                                         {words_.rig_says, 48, false}}};
    std::vector<std::vector<std::string>> rows;
    for (const ReportFault& fault : report_.faults) {
      if (rows.size() == kFaultsShown) break;
      const bool nominal = fault.value == fault.component.info().nominal;
      rows.push_back({Fixed(fault.t_s, 2),
                      std::to_string(fault.index),
                      std::string(core::Name(fault.component)),
                      ValueOf(fault.component, fault.value) +
                          (nominal ? std::string(" (") + words_.nominal + ")" : ""),
                      fault.said == ReportFault::Said::kConfirmed ? words_.confirmed
                      : fault.said == ReportFault::Said::kRefused ? words_.refused
                                                                  : words_.unconfirmed});
    }
    paper.Table(columns, rows);
    if (report_.faults.size() > kFaultsShown) {
      paper.Paragraph(
          Fill(words_.faults_more, {std::to_string(report_.faults.size() - kFaultsShown)}));
    }
  }

  void Estimates(PdfDocument& paper) const {
    if (report_.changes.empty()) return;
    paper.Heading(words_.before_after);
    for (const ReportChange& change : report_.changes) Estimates(paper, change);
    paper.Paragraph(words_.means, PdfDocument::Tone::kQuiet);
  }

 private:
  void Estimates(PdfDocument& paper, const ReportChange& change) const {
    const std::string about = About(change);
    if (!about.empty()) paper.Paragraph(about);
    const bool published = !report_.bench->published.source.empty();
    std::vector<PdfDocument::Column> columns = {{words_.parameter, 20, false},
                                                {"", 38, false},
                                                {words_.before, 23, true},
                                                {words_.after, 23, true},
                                                {words_.change, 23, true},
                                                {words_.model, 23, true}};
    if (published) columns.push_back({words_.published, 24, true});
    std::vector<std::vector<std::string>> rows;
    for (const ReportEstimates& one : change.estimates) {
      for (const ReportEstimates::Row& row : one.rows) {
        const bool both = row.before && row.after && *row.before != 0.0;
        rows.push_back({row.name,
                        one.title,
                        Number(row.before),
                        Number(row.after),
                        both ? Change(*row.before, *row.after) : "–",
                        Number(row.model)});
        if (published) rows.back().push_back(Number(row.published));
      }
    }
    paper.Table(columns, rows);
  }

  /// "R12: 11.2 kΩ → 5.6 kΩ at 8.00 s"
  std::string About(const ReportChange& change) const {
    if (!change.t_s) return {};
    if (!change.component.exists()) return Fill(words_.change_at, {Fixed(*change.t_s, 2)});
    std::string text = std::string(core::Name(change.component)) + ": ";
    if (change.before) text += ValueOf(change.component, *change.before) + " → ";
    text = Fill(words_.changed_at,
                {text + ValueOf(change.component, change.value), Fixed(*change.t_s, 2)});
    std::string others;
    for (const core::Component other : change.others) {
      others.append(others.empty() ? "" : ", ").append(core::Name(other));
    }
    if (!others.empty()) text += Fill(words_.no_model, {others});
    return text;
  }

  /// Of the magnitude, as the page has it: −1.1 -> −0.66 is −40 %.
  std::string Change(double before, double after) const {
    constexpr double kPercent = 100.0;
    const double change = kPercent * (after / before - 1.0);
    return (change > 0.0 ? "+" : "") + Fixed(change, 0);
  }
};

}  // namespace

void WriteFaults(const RunReport& report, const ReportWords& words, PdfDocument& paper) {
  ChangesSection(report, words).Faults(paper);
}

void WriteEstimates(const RunReport& report, const ReportWords& words, PdfDocument& paper) {
  ChangesSection(report, words).Estimates(paper);
}

}  // namespace faultlab::server

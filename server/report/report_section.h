#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/types/component.h"
#include "server/report/pdf_document.h"
#include "server/report/report.h"
#include "server/report/report_words.h"

namespace faultlab::server {

/// A part of a report: its values, its words, and numbers as its language writes them.
class ReportSection {
 protected:
  static constexpr double kMilli = 1e3;

  ReportSection(const RunReport& report, const ReportWords& words)
      : report_(report), words_(words) {}

  /// "1.86·10⁻⁵" for 1.86e-05; a large number has no power: "1857".
  std::string Digits(double value, int digits) const;
  /// Without "-0.0".
  std::string Fixed(double value, int decimals) const;
  /// For tables and the path, as the page writes it: four digits, "0.07870".
  std::string Number(std::optional<double> value) const;
  /// With at least so many digits, and never fewer than stand before the point: as the page does.
  std::string Factor(double value, int digits) const;
  /// "5.6 kΩ" of a value in SI.
  std::string ValueOf(core::Component component, double value) const;
  /// "99.6 ± 0.4 Ω" of a value in SI.
  std::string WithError(double value, double sigma, std::string_view unit) const;

  const RunReport& report_;
  const ReportWords& words_;

 private:
  std::string Local(std::string number) const;
};

/// "R1 or B"
std::string Joined(std::span<const core::Component> components, std::string_view word);

/// "2026-11-21T01:02:03.456Z" -> "2026-11-21 01:02:03 UTC"
std::string Readable(const std::string& iso);

void WriteFacts(const RunReport& report, const ReportWords& words, PdfDocument& paper);
void WriteVerdict(const RunReport& report, const ReportWords& words, PdfDocument& paper);
/// The paper's method, and why it ends elsewhere than the verdict.
void WritePath(const RunReport& report, const ReportWords& words, PdfDocument& paper);
/// The components that were switched.
void WriteFaults(const RunReport& report, const ReportWords& words, PdfDocument& paper);
/// The estimates before and after each change.
void WriteEstimates(const RunReport& report, const ReportWords& words, PdfDocument& paper);

}  // namespace faultlab::server

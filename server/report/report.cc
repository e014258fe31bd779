#include "server/report/report.h"

#include <algorithm>

#include "server/plots/render.h"
#include "server/report/pdf_document.h"
#include "server/report/report_section.h"

namespace faultlab::server {
namespace {

constexpr int kPagesMax = 3;

/// "2026-11-21T01:02:03.456Z" -> "2026-11-21T01:02:03Z", which cairo reads.
std::string ToTheSecond(const std::string& iso) {
  return iso.substr(0, iso.find('.')) + (iso.find('.') == std::string::npos ? "" : "Z");
}

/// Writes one report onto a paper.
class Writer {
 public:
  Writer(const RunReport& report, Language language) : report_(report), words_(WordsOf(language)) {}

  PdfDocument::About About(int pages_total) const {
    return {.title = Title(),
            .author = report_.made_by,
            .creator = "faultlab " + report_.version,
            .made_at = ToTheSecond(report_.ended_at.empty() ? report_.began_at : report_.ended_at),
            .footer = std::string(words_.run) + " " + report_.id,
            .pages_total = pages_total};
  }

  void Text(PdfDocument& paper) const {
    if (!report_.address.empty()) {
      if (const auto code = MakeQrCode(report_.address)) paper.Code(*code, report_.address);
    }
    paper.Paragraph(words_.report, PdfDocument::Tone::kQuiet);
    paper.Title(Title());
    WriteFacts(report_, words_, paper);
    WriteVerdict(report_, words_, paper);
    WritePath(report_, words_, paper);
    WriteFaults(report_, words_, paper);
    WriteEstimates(report_, words_, paper);
    Origin(paper);
  }

  /// A figure that could not be drawn is a sentence.
  void Figures(PdfDocument& paper,
               const std::vector<core::Result<Pixels>>& pictures,
               double height_mm) const {
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      const std::string caption = Caption(report_.figures[i]);
      if (pictures[i].ok()) {
        paper.Picture(pictures[i].value(), height_mm, caption);
      } else {
        paper.Paragraph(Fill(words_.no_figure, {caption, pictures[i].error().message}));
      }
    }
  }

 private:
  /// Of a run without a name: its rig and when it was.
  std::string Title() const {
    if (!report_.name.empty()) return report_.name;
    return (report_.rig.empty() ? words_.uploaded : report_.rig) + ", " +
           Readable(report_.began_at);
  }

  std::string Caption(const std::string& name) const {
    if (name == "signals") return words_.figure_signals;
    if (name == "swa") return words_.figure_swa;
    if (name == "sia") return words_.figure_sia;
    return words_.figure_models;
  }

  void Origin(PdfDocument& paper) const {
    paper.Heading(words_.origin);
    paper.Fact(words_.program, "faultlab " + report_.version);
    paper.Fact(words_.checksum, report_.csv_sha256);
    paper.Fact(words_.address, report_.address);
    if (report_.address.empty()) paper.Paragraph(words_.no_address, PdfDocument::Tone::kQuiet);
  }

  const RunReport& report_;
  const ReportWords& words_;
};

/// The largest height at which `count` pictures fit on the pages that are left.
double PictureHeight(std::size_t count, int page, double left_mm) {
  constexpr double kHighest = 120.0;
  constexpr double kLowest = 60.0;
  constexpr double kStep = 2.0;
  for (double height = kHighest; height > kLowest; height -= kStep) {
    const double each = PdfDocument::PictureMm(height);
    const auto fits = [&](double room) {
      return static_cast<std::size_t>(std::max(0.0, room / each));
    };
    std::size_t room = fits(left_mm);
    for (int next = page + 1; next <= kPagesMax; ++next) room += fits(PdfDocument::kHeightMm);
    if (room >= count) return height;
  }
  return kLowest;
}

/// For a draft, which needs their number alone.
std::vector<core::Result<Pixels>> WithoutPixels(const std::vector<core::Result<Pixels>>& pictures) {
  std::vector<core::Result<Pixels>> out;
  for (const auto& picture : pictures) {
    out.push_back(picture ? core::Result<Pixels>(Pixels{}) : picture.error());
  }
  return out;
}

/// A picture under a caption needs no heading and no footer of its own.
Figure Bare(Figure figure) {
  figure.title.clear();
  figure.subtitle.clear();
  figure.footer.clear();
  return figure;
}

}  // namespace

core::Result<std::string> ReportPdf(const RunReport& report, Language language) {
  const Writer writer(report, language);
  double height_mm = 0.0;
  {
    TRY(auto draft, PdfDocument::Open(writer.About(0)));
    writer.Text(*draft);
    height_mm = PictureHeight(report.figures.size(), draft->page(), draft->left_mm());
  }
  std::vector<core::Result<Pixels>> pictures;
  for (const std::string& name : report.figures) {
    auto figure = report.figure(name);
    pictures.push_back(
        figure ? RenderForPrint(Bare(std::move(figure).value()), PdfDocument::kWidthMm, height_mm)
               : figure.error());
  }
  int pages = 0;
  {
    TRY(auto draft, PdfDocument::Open(writer.About(0)));
    writer.Text(*draft);
    writer.Figures(*draft, WithoutPixels(pictures), height_mm);
    pages = draft->page();
  }
  TRY(auto paper, PdfDocument::Open(writer.About(pages)));
  writer.Text(*paper);
  writer.Figures(*paper, pictures, height_mm);
  return paper->Finish();
}

}  // namespace faultlab::server

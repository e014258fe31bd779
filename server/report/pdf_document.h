#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/types/result.h"
#include "server/plots/render.h"
#include "server/report/qr_code.h"

namespace faultlab::server {

/// A4 pages as PDF, filled from top to bottom; what does not fit on a page begins the next one.
/// Text is UTF-8 and stays text: it can be selected and searched. Letters that DejaVu Sans lacks
/// are empty boxes; bytes that are not UTF-8 become U+FFFD. The same calls give the same bytes. One
/// paper at a time exists in the process, because all share one font: Open waits.
class PdfDocument {
 public:
  static constexpr double kWidthMm = 174.0;  ///< between the margins
  static constexpr double kHeightMm = 261.0;

  struct About {
    std::string title;
    std::string author;
    std::string creator;  ///< "faultlab 0.1.0"
    std::string made_at;  ///< ISO 8601, UTC: the only date in the file
    std::string footer;   ///< at the bottom of each page, left
    int pages_total = 0;  ///< for "1 / 3"; 0: not known yet
  };
  /// kUnavailable without a font; the message names the package.
  static core::Result<std::unique_ptr<PdfDocument>> Open(About about);
  virtual ~PdfDocument() = default;

  virtual void Title(std::string_view text) = 0;
  virtual void Heading(std::string_view text) = 0;
  enum class Tone { kPlain, kStrong, kQuiet };
  virtual void Paragraph(std::string_view text, Tone tone = Tone::kPlain) = 0;
  /// Name and value, side by side; a long value takes several lines.
  virtual void Fact(std::string_view name, std::string_view value) = 0;
  struct Column {
    std::string title;
    double width_mm = 20.0;
    bool number = false;  ///< set to the right
  };
  /// A cell that is too long ends in "…".
  virtual void Table(std::span<const Column> columns,
                     std::span<const std::vector<std::string>> rows) = 0;
  /// A picture as wide as the text with its caption above; both on one page.
  virtual void Picture(const Pixels& pixels, double height_mm, std::string_view caption) = 0;
  /// At the top right corner of the first page, a link to `address` as well. Before any text, which
  /// then leaves its place free.
  virtual void Code(const QrCode& code, const std::string& address) = 0;

  static double PictureMm(double height_mm);  ///< with caption and space
  virtual double left_mm() const = 0;         ///< free on this page
  virtual int page() const = 0;               ///< 1 for the first
  /// The PDF. kUnavailable when it could not be made. The last call.
  virtual core::Result<std::string> Finish() = 0;
};

}  // namespace faultlab::server

#include "server/report/pdf_document.h"

#include <cairo-pdf.h>
#include <unistd.h>

#include <algorithm>
#include <mutex>
#include <utility>

#include "server/report/pdf_text.h"

namespace faultlab::server {
namespace {

constexpr double kPointsPerMm = 72.0 / 25.4;
constexpr double kPageWidth = 210.0 * kPointsPerMm;
constexpr double kPageHeight = 297.0 * kPointsPerMm;
constexpr double kLeft = 18.0 * kPointsPerMm;
constexpr double kTop = 16.0 * kPointsPerMm;
constexpr double kWidth = PdfDocument::kWidthMm * kPointsPerMm;
constexpr double kBottom = kTop + PdfDocument::kHeightMm * kPointsPerMm;
constexpr double kFooterY = kPageHeight - 11.0 * kPointsPerMm;

constexpr double kTitlePt = 17.0;
constexpr double kHeadingPt = 10.5;
constexpr double kTextPt = 8.8;
constexpr double kSmallPt = 7.5;
constexpr double kLine = 1.32;  ///< line height over size
constexpr double kFactName = 38.0 * kPointsPerMm;
constexpr double kCodeSide = 24.0 * kPointsPerMm;
constexpr double kAbove = 9.0;  // a heading, and a picture below text
constexpr double kCaptionHeight = 15.0;
constexpr double kPictureGap = 8.0;

struct Grey {
  double level;
};
constexpr Grey kInk{0.13};
constexpr Grey kQuietInk{0.38};
constexpr Grey kRule{0.78};

std::mutex& OnePaper() {
  static std::mutex mutex;
  return mutex;
}

cairo_status_t Append(void* out, const unsigned char* bytes, unsigned int size) {
  static_cast<std::string*>(out)->append(reinterpret_cast<const char*>(bytes), size);
  return CAIRO_STATUS_SUCCESS;
}

/// An element of the document's structure, which readers for the blind and text extraction follow.
class Tagged {
 public:
  Tagged(cairo_t* cr, const char* name, const std::string& attributes = {}) : cr_(cr), name_(name) {
    cairo_tag_begin(cr_, name_, attributes.empty() ? nullptr : attributes.c_str());
  }
  ~Tagged() { cairo_tag_end(cr_, name_); }
  Tagged(const Tagged&) = delete;
  Tagged& operator=(const Tagged&) = delete;

 private:
  cairo_t* cr_;
  const char* name_;
};

class CairoPaper final : public PdfDocument {
 public:
  CairoPaper(About about, PdfFonts fonts, std::unique_lock<std::mutex> turn)
      : turn_(std::move(turn)), about_(std::move(about)), fonts_(fonts) {
    surface_ = cairo_pdf_surface_create_for_stream(&Append, &pdf_, kPageWidth, kPageHeight);
    const auto say = [this](cairo_pdf_metadata_t what, const std::string& text) {
      if (!text.empty()) cairo_pdf_surface_set_metadata(surface_, what, Clean(text).c_str());
    };
    say(CAIRO_PDF_METADATA_TITLE, about_.title);
    say(CAIRO_PDF_METADATA_AUTHOR, about_.author);
    say(CAIRO_PDF_METADATA_CREATOR, about_.creator);
    say(CAIRO_PDF_METADATA_CREATE_DATE, about_.made_at);
    say(CAIRO_PDF_METADATA_MOD_DATE, about_.made_at);
    cr_ = cairo_create(surface_);
    cairo_font_options_t* options = cairo_font_options_create();
    cairo_font_options_set_hint_style(options, CAIRO_HINT_STYLE_NONE);
    cairo_font_options_set_hint_metrics(options, CAIRO_HINT_METRICS_OFF);
    cairo_set_font_options(cr_, options);
    cairo_font_options_destroy(options);
  }
  ~CairoPaper() override { Close(); }

  void Title(std::string_view text) override {
    const Tagged tag(cr_, "H1");
    Wrapped(text, kLeft, ColumnWidth(), kTitlePt, true, kInk);
    y_ += 2.0;
  }

  void Heading(std::string_view text) override {
    constexpr double kKeepWithNext = 36.0;
    if (y_ + kAbove + kHeadingPt * kLine + kKeepWithNext > kBottom) {
      NewPage();
    } else {
      y_ += kAbove;
    }
    {
      const Tagged tag(cr_, "H2");
      Wrapped(text, kLeft, ColumnWidth(), kHeadingPt, true, kInk);
    }
    Rule(y_ + 0.5);
    y_ += 3.5;
  }

  void Paragraph(std::string_view text, Tone tone) override {
    const Tagged tag(cr_, "P");
    const bool quiet = tone == Tone::kQuiet;
    Wrapped(text,
            kLeft,
            ColumnWidth(),
            quiet ? kSmallPt : kTextPt,
            tone == Tone::kStrong,
            quiet ? kQuietInk : kInk);
    y_ += 1.5;
  }

  void Fact(std::string_view name, std::string_view value) override {
    if (value.empty()) return;
    const Tagged tag(cr_, "P");
    Room(kTextPt * kLine);
    const double top = y_;
    Line(Clean(name), kLeft, top, kTextPt, false, kQuietInk);
    Wrapped(value, kLeft + kFactName, ColumnWidth() - kFactName, kTextPt, false, kInk);
  }

  void Table(std::span<const Column> columns,
             std::span<const std::vector<std::string>> rows) override {
    const Tagged tag(cr_, "Table");
    const auto head = [&] {
      std::vector<std::string> titles;
      for (const Column& column : columns) titles.push_back(column.title);
      Row(columns, titles, true);
      Rule(y_);
      y_ += 1.5;
    };
    Room(2 * kRowHeight);
    head();
    for (const std::vector<std::string>& row : rows) {
      if (y_ + kRowHeight > kBottom) {
        NewPage();
        head();
      }
      Row(columns, row, false);
    }
    y_ += 2.0;
  }

  void Picture(const Pixels& pixels, double height_mm, std::string_view caption) override {
    const double needed = PictureMm(height_mm) * kPointsPerMm - kPictureGap;
    if (kBottom - y_ < needed) NewPage();
    if (below_text_) y_ += std::clamp(kBottom - y_ - needed, 0.0, kAbove);
    below_text_ = false;
    {
      const Tagged tag(cr_, "P");
      Line(Clean(caption), kLeft, y_, kTextPt, true, kInk);
    }
    y_ += kCaptionHeight;
    const double height = height_mm * kPointsPerMm;
    if (pixels.width > 0) {
      const Tagged tag(cr_, "Figure");
      Paint(pixels, height);
    }
    y_ += height + kPictureGap;
  }

  void Code(const QrCode& code, const std::string& address) override {
    const double x = kLeft + kWidth - kCodeSide;
    const double square = kCodeSide / code.width;
    Set(kInk);
    for (int row = 0; row < code.width; ++row) {
      for (int column = 0; column < code.width; ++column) {
        if (!code.dark[static_cast<std::size_t>(row * code.width + column)]) continue;
        cairo_rectangle(cr_, x + column * square, kTop + row * square, square, square);
      }
    }
    cairo_fill(cr_);
    code_bottom_ = kTop + kCodeSide + 4.0;
    std::string quoted;
    for (const char c : address) {
      if (c == '\'' || c == '\\') quoted += '\\';
      quoted += c;
    }
    cairo_tag_begin(
        cr_,
        CAIRO_TAG_LINK,
        ("uri='" + quoted + "' rect=[" + std::to_string(x) + " " + std::to_string(kTop) + " " +
         std::to_string(kCodeSide) + " " + std::to_string(kCodeSide) + "]")
            .c_str());
    cairo_tag_end(cr_, CAIRO_TAG_LINK);
  }

  double left_mm() const override { return (kBottom - y_) / kPointsPerMm; }
  int page() const override { return page_; }

  core::Result<std::string> Finish() override {
    EndPage();
    cairo_surface_finish(surface_);
    const cairo_status_t status = std::max(cairo_status(cr_), cairo_surface_status(surface_));
    Close();
    if (status != CAIRO_STATUS_SUCCESS) {
      return core::Error{
          core::ErrorCode::kUnavailable,
          std::string("the report could not be written: ") + cairo_status_to_string(status),
          "",
          "internal"};
    }
    return std::move(pdf_);
  }

 private:
  static constexpr double kRowHeight = kTextPt * kLine;

  void Close() {
    if (cr_ != nullptr) cairo_destroy(cr_);
    if (surface_ != nullptr) cairo_surface_destroy(surface_);
    cr_ = nullptr;
    surface_ = nullptr;
  }

  void Set(Grey ink) { cairo_set_source_rgb(cr_, ink.level, ink.level, ink.level); }

  void Font(double size, bool strong) {
    cairo_set_font_face(cr_, strong ? fonts_.strong : fonts_.plain);
    cairo_set_font_size(cr_, size);
  }

  /// Beside the code the lines are shorter.
  double ColumnWidth() const { return y_ < code_bottom_ ? kWidth - kCodeSide - 10.0 : kWidth; }

  void Room(double height) {
    if (y_ + height > kBottom) NewPage();
  }

  void EndPage() {
    Font(kSmallPt, false);
    Set(kQuietInk);
    cairo_move_to(cr_, kLeft, kFooterY);
    cairo_show_text(cr_, Clean(about_.footer).c_str());
    const std::string number =
        std::to_string(page_) +
        (about_.pages_total > 0 ? " / " + std::to_string(about_.pages_total) : std::string());
    cairo_move_to(cr_, kLeft + kWidth - TextWidth(cr_, number), kFooterY);
    cairo_show_text(cr_, number.c_str());
    cairo_show_page(cr_);
  }

  void NewPage() {
    EndPage();
    ++page_;
    y_ = kTop;
    below_text_ = false;
    code_bottom_ = 0.0;
  }

  void Rule(double y) {
    Set(kRule);
    cairo_set_line_width(cr_, 0.5);
    cairo_move_to(cr_, kLeft, y);
    cairo_line_to(cr_, kLeft + ColumnWidth(), y);
    cairo_stroke(cr_);
  }

  /// One line whose upper edge is `top`; y_ stays.
  void Line(const std::string& text, double x, double top, double size, bool strong, Grey ink) {
    Font(size, strong);
    Set(ink);
    cairo_move_to(cr_, x, top + size);
    cairo_show_text(cr_, text.c_str());
  }

  /// As many lines as the text needs; moves y_ below them.
  void Wrapped(std::string_view raw, double x, double width, double size, bool strong, Grey ink) {
    const std::string text = Clean(raw);
    std::size_t at = 0;
    while (at < text.size()) {
      Font(size, strong);
      const std::size_t end = LineEnd(cr_, text, at, width);
      Room(size * kLine);
      std::string line = text.substr(at, end - at);
      while (!line.empty() && line.back() == ' ') line.pop_back();
      Line(line, x, y_, size, strong, ink);
      y_ += size * kLine;
      below_text_ = true;
      at = end;
      while (at < text.size() && text[at] == ' ') ++at;
    }
  }

  void Row(std::span<const Column> columns, const std::vector<std::string>& cells, bool head) {
    const double size = head ? kSmallPt : kTextPt;
    const Tagged tag(cr_, "P");
    double x = kLeft;
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const double width = columns[i].width_mm * kPointsPerMm;
      const double gap = columns[i].number ? 14.0 : 5.0;
      Font(size, false);
      const std::string text = Shortened(cr_, Clean(i < cells.size() ? cells[i] : ""), width - gap);
      const double shift = columns[i].number ? width - gap - TextWidth(cr_, text) : 0.0;
      Line(text, x + shift, y_, size, false, head ? kQuietInk : kInk);
      x += width;
    }
    y_ += size * kLine;
  }

  void Paint(const Pixels& pixels, double height) {
    cairo_surface_t* image =
        cairo_image_surface_create(CAIRO_FORMAT_RGB24, pixels.width, pixels.height);
    if (cairo_surface_status(image) == CAIRO_STATUS_SUCCESS) {
      unsigned char* rows = cairo_image_surface_get_data(image);
      const int stride = cairo_image_surface_get_stride(image);
      const std::uint8_t* from = pixels.rgb.data();
      for (int row = 0; row < pixels.height; ++row) {
        auto* out =
            reinterpret_cast<std::uint32_t*>(rows + static_cast<std::ptrdiff_t>(row) * stride);
        for (int column = 0; column < pixels.width; ++column, from += 3) {
          *out++ = (std::uint32_t{from[0]} << 16) | (std::uint32_t{from[1]} << 8) | from[2];
        }
      }
      cairo_surface_mark_dirty(image);
    }
    cairo_save(cr_);
    cairo_translate(cr_, kLeft, y_);
    cairo_scale(cr_, kWidth / pixels.width, height / pixels.height);
    cairo_set_source_surface(cr_, image, 0.0, 0.0);
    cairo_paint(cr_);
    cairo_restore(cr_);
    cairo_surface_destroy(image);
  }

  std::unique_lock<std::mutex> turn_;
  About about_;
  PdfFonts fonts_;
  std::string pdf_;
  cairo_surface_t* surface_ = nullptr;
  cairo_t* cr_ = nullptr;
  double y_ = kTop;
  bool below_text_ = false;   ///< on this page
  double code_bottom_ = 0.0;  ///< of the code, on its page
  int page_ = 1;
};

}  // namespace

core::Result<std::unique_ptr<PdfDocument>> PdfDocument::Open(About about) {
  std::unique_lock<std::mutex> turn(OnePaper());
  TRY(auto fonts, LoadPdfFonts());
  return std::unique_ptr<PdfDocument>(
      std::make_unique<CairoPaper>(std::move(about), fonts, std::move(turn)));
}

double PdfDocument::PictureMm(double height_mm) {
  return height_mm + (kCaptionHeight + kPictureGap) / kPointsPerMm;
}

}  // namespace faultlab::server

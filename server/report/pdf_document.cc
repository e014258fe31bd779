#include "server/report/pdf_document.h"

#include <cairo-ft.h>
#include <cairo-pdf.h>
#include <ft2build.h>
#include FT_FREETYPE_H
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <utility>

#include "core/types/utf8.h"
#include "server/plots/typeface.h"

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

/// Valid UTF-8 without control characters: cairo stops at anything else.
std::string Clean(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const core::Utf8Character first = core::FirstCharacter(text);
    const bool control = first.code < 0x20 || (first.code >= 0x7F && first.code < 0xA0);
    if (!first.valid) {
      out += "\uFFFD";
    } else if (control) {
      out += ' ';
    } else {
      out += text.substr(0, first.bytes);
    }
    text.remove_prefix(first.bytes);
  }
  return out;
}

/// The end of the character that begins at `at`.
std::size_t NextCharacter(std::string_view text, std::size_t at) {
  return at + core::FirstCharacter(text.substr(at)).bytes;
}

/// The fonts exist until the process ends: cairo keeps what it has measured of them.
struct Fonts {
  cairo_font_face_t* plain = nullptr;
  cairo_font_face_t* strong = nullptr;
};

std::string StrongOf(std::string path) {
  const std::size_t at = path.rfind(".ttf");
  if (at == std::string::npos) return path;
  path.insert(at, "-Bold");
  return path;
}

core::Result<Fonts> LoadFonts() {
  static Fonts fonts;
  static FT_Library library = nullptr;
  const auto unavailable = [](const std::string& what) {
    return core::Error{core::ErrorCode::kUnavailable,
                       what +
                           "; install the package fonts-dejavu-core or set FAULTLAB_FONT to a "
                           "TrueType file",
                       "",
                       "font_missing"};
  };
  if (fonts.plain != nullptr) return fonts;
  if (library == nullptr && FT_Init_FreeType(&library) != 0) {
    return unavailable("FreeType does not start");
  }
  const std::string path = Typeface::Find();
  FT_Face plain = nullptr;
  if (path.empty() || FT_New_Face(library, path.c_str(), 0, &plain) != 0) {
    return unavailable("no font for the report");
  }
  FT_Face strong = nullptr;
  if (FT_New_Face(library, StrongOf(path).c_str(), 0, &strong) != 0) strong = plain;
  fonts.plain = cairo_ft_font_face_create_for_ft_face(plain, FT_LOAD_NO_HINTING);
  fonts.strong = cairo_ft_font_face_create_for_ft_face(strong, FT_LOAD_NO_HINTING);
  return fonts;
}

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
  CairoPaper(About about, Fonts fonts, std::unique_lock<std::mutex> turn)
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
    Wrapped(text, kLeft, TextWidth(), kTitlePt, true, kInk);
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
      Wrapped(text, kLeft, TextWidth(), kHeadingPt, true, kInk);
    }
    Rule(y_ + 0.5);
    y_ += 3.5;
  }

  void Paragraph(std::string_view text, Tone tone) override {
    const Tagged tag(cr_, "P");
    const bool quiet = tone == Tone::kQuiet;
    Wrapped(text,
            kLeft,
            TextWidth(),
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
    Wrapped(value, kLeft + kFactName, TextWidth() - kFactName, kTextPt, false, kInk);
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

  double Width(const std::string& text) {
    cairo_text_extents_t extents;
    cairo_text_extents(cr_, text.c_str(), &extents);
    return extents.x_advance;
  }

  /// Beside the code the lines are shorter.
  double TextWidth() const { return y_ < code_bottom_ ? kWidth - kCodeSide - 10.0 : kWidth; }

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
    cairo_move_to(cr_, kLeft + kWidth - Width(number), kFooterY);
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
    cairo_line_to(cr_, kLeft + TextWidth(), y);
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
      const std::size_t end = LineEnd(text, at, width);
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

  /// Where the line that begins at `at` ends: behind its last whole word; inside a word only when
  /// it fills the line alone.
  std::size_t LineEnd(const std::string& text, std::size_t at, double width) {
    std::size_t fits = at;
    double used = 0.0;  // advances add up: cairo does not kern
    while (fits < text.size()) {
      const std::size_t end = std::min(text.find(' ', fits + 1), text.size());
      used += Width(text.substr(fits, end - fits));
      if (used > width) break;
      fits = end;
    }
    if (fits > at) return fits;
    std::size_t end = NextCharacter(text, at);
    used = Width(text.substr(at, end - at));
    while (end < text.size() && text[end] != ' ') {
      const std::size_t next = NextCharacter(text, end);
      used += Width(text.substr(end, next - end));
      if (used > width) break;
      end = next;
    }
    return end;
  }

  void Row(std::span<const Column> columns, const std::vector<std::string>& cells, bool head) {
    const double size = head ? kSmallPt : kTextPt;
    const Tagged tag(cr_, "P");
    double x = kLeft;
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const double width = columns[i].width_mm * kPointsPerMm;
      const double gap = columns[i].number ? 14.0 : 5.0;
      Font(size, false);
      const std::string text = Shortened(Clean(i < cells.size() ? cells[i] : ""), width - gap);
      const double shift = columns[i].number ? width - gap - Width(text) : 0.0;
      Line(text, x + shift, y_, size, false, head ? kQuietInk : kInk);
      x += width;
    }
    y_ += size * kLine;
  }

  std::string Shortened(std::string text, double width) {
    if (Width(text) <= width) return text;
    const std::string dots = "…";
    double used = Width(dots);
    std::size_t end = 0;
    while (end < text.size()) {
      const std::size_t next = NextCharacter(text, end);
      used += Width(text.substr(end, next - end));
      if (used > width) break;
      end = next;
    }
    return text.substr(0, end) + dots;
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
  Fonts fonts_;
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
  auto fonts = LoadFonts();
  if (!fonts) return fonts.error();
  return std::unique_ptr<PdfDocument>(
      std::make_unique<CairoPaper>(std::move(about), fonts.value(), std::move(turn)));
}

double PdfDocument::PictureMm(double height_mm) {
  return height_mm + (kCaptionHeight + kPictureGap) / kPointsPerMm;
}

}  // namespace faultlab::server

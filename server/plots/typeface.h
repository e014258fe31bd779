#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/types/result.h"

namespace faultlab::server {

/// Grey levels of a line of text, row by row; `baseline` is the row of the base line.
struct TextBitmap {
  int width = 0;
  int height = 0;
  int baseline = 0;
  std::vector<std::uint8_t> coverage;  ///< [height x width], 0 = paper, 255 = ink
};

/// One TrueType face through FreeType. Text is UTF-8 and may contain "_{..}" (subscript) and
/// "^{..}" (superscript). A letter that the face does not have is drawn as an empty box. Not
/// thread-safe.
class Typeface {
 public:
  /// `path` empty: $FAULTLAB_FONT, then the places where Linux distributions put DejaVuSans.ttf.
  static core::Result<std::unique_ptr<Typeface>> Load(const std::string& path);
  virtual ~Typeface() = default;

  /// The file that Load would read; empty when there is none.
  static std::string Find(const std::string& path = {});

  virtual int Width(std::string_view text, int size_px) = 0;
  virtual TextBitmap Draw(std::string_view text, int size_px) = 0;
};

}  // namespace faultlab::server

#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>

#include "tests/support/temp_folder.h"

namespace faultlab::tests {

/// Without blanks, as PdfReader::Text.
inline std::string Squeezed(std::string text) {
  std::erase(text, ' ');
  return text;
}

/// A PDF as poppler, which is independent, reads it.
class PdfReader {
 public:
  explicit PdfReader(const std::string& pdf) {
    std::ofstream(folder_.File("a.pdf"), std::ios::binary) << pdf;
  }
  /// Of one page, or of all. Without blanks and line ends: what stands between two numbers depends
  /// on their distance.
  std::string Text(int page = 0) {
    const std::string pages =
        page == 0 ? "" : "-f " + std::to_string(page) + " -l " + std::to_string(page) + " ";
    std::istringstream words(Output("pdftotext -layout " + pages + folder_.File("a.pdf") + " -"));
    std::string out;
    for (std::string word; words >> word;) out += word;
    return out;
  }
  std::string Info() { return Output("pdfinfo " + folder_.File("a.pdf")); }
  int Pages() {
    const std::string info = Info();
    const std::size_t at = info.find("Pages:");
    return at == std::string::npos ? 0 : std::atoi(info.c_str() + at + 6);
  }
  /// The share of pixels of a page that have a colour.
  double Coloured(int page) {
    const std::string number = std::to_string(page);
    const std::string image =
        Output("pdftoppm -r 80 -f " + number + " -l " + number + " " + folder_.File("a.pdf"));
    std::istringstream head(image);
    std::string magic;
    int width = 0;
    int height = 0;
    int most = 0;
    head >> magic >> width >> height >> most;
    EXPECT_EQ(magic, "P6");
    const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    if (image.size() < 3 * pixels || pixels == 0) return 0.0;
    const char* rgb = image.data() + image.size() - 3 * pixels;
    std::size_t coloured = 0;
    for (std::size_t i = 0; i < pixels; ++i) {
      const auto byte = [&](std::size_t k) {
        return static_cast<int>(static_cast<unsigned char>(rgb[3 * i + k]));
      };
      constexpr int kVisible = 40;
      const int least = std::min({byte(0), byte(1), byte(2)});
      if (std::max({byte(0), byte(1), byte(2)}) - least > kVisible) ++coloured;
    }
    return static_cast<double>(coloured) / static_cast<double>(pixels);
  }

 private:
  static std::string Output(const std::string& command) {
    std::FILE* pipe = ::popen((command + " 2>&1").c_str(), "r");
    EXPECT_NE(pipe, nullptr) << command;
    if (pipe == nullptr) return {};
    std::string out;
    std::array<char, 4096> piece;
    for (std::size_t n = 0; (n = std::fread(piece.data(), 1, piece.size(), pipe)) > 0;) {
      out.append(piece.data(), n);
    }
    EXPECT_EQ(::pclose(pipe), 0) << command << ": " << out.substr(0, 300)
                                 << " (package poppler-utils)";
    return out;
  }

  TempFolder folder_;
};

}  // namespace faultlab::tests

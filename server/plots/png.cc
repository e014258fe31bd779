#include "server/plots/png.h"

#include <zlib.h>

#include <string_view>
#include <vector>

#include "core/types/check.h"

namespace faultlab::server {
namespace {

constexpr std::string_view kSignature("\x89PNG\r\n\x1a\n", 8);
constexpr std::uint8_t kFilterUp = 2;
constexpr int kBytesPerPixel = 3;

void AppendBigEndian(std::string& out, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) {
    out += static_cast<char>((value >> shift) & 0xFF);
  }
}

void AppendChunk(std::string& out, std::string_view type, std::string_view data) {
  AppendBigEndian(out, static_cast<std::uint32_t>(data.size()));
  const std::size_t start = out.size();
  out += type;
  out += data;
  const auto* bytes = reinterpret_cast<const Bytef*>(out.data() + start);
  const uLong crc = ::crc32(::crc32(0, nullptr, 0), bytes, static_cast<uInt>(out.size() - start));
  AppendBigEndian(out, static_cast<std::uint32_t>(crc));
}

/// Each row as its difference to the row above, preceded by the number of the filter.
std::vector<std::uint8_t> FilterRows(std::span<const std::uint8_t> rgb,
                                     std::size_t stride,
                                     std::size_t height) {
  std::vector<std::uint8_t> filtered((stride + 1) * height);
  const std::vector<std::uint8_t> nothing(stride, 0);
  const std::uint8_t* above = nothing.data();
  std::uint8_t* out = filtered.data();
  for (std::size_t row = 0; row < height; ++row) {
    const std::uint8_t* line = rgb.data() + row * stride;
    *out++ = kFilterUp;
    for (std::size_t i = 0; i < stride; ++i) {
      out[i] = static_cast<std::uint8_t>(line[i] - above[i]);
    }
    out += stride;
    above = line;
  }
  return filtered;
}

std::string Deflate(std::span<const std::uint8_t> bytes, int level) {
  z_stream stream{};
  constexpr int kMemoryLevel = 9;
  LAB_CHECK(::deflateInit2(&stream, level, Z_DEFLATED, MAX_WBITS, kMemoryLevel, Z_RLE) == Z_OK,
            level);
  std::string out(::deflateBound(&stream, static_cast<uLong>(bytes.size())), '\0');
  stream.next_in = const_cast<Bytef*>(bytes.data());  // zlib reads only
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  const int code = ::deflate(&stream, Z_FINISH);
  LAB_CHECK(code == Z_STREAM_END, code);
  out.resize(stream.total_out);
  ::deflateEnd(&stream);
  return out;
}

}  // namespace

std::string EncodePng(std::span<const std::uint8_t> rgb,
                      int width,
                      int height,
                      int level,
                      std::uint32_t pixels_per_metre) {
  LAB_CHECK(width > 0 && height > 0, width, height);
  const std::size_t stride = static_cast<std::size_t>(width) * kBytesPerPixel;
  LAB_CHECK(rgb.size() == stride * static_cast<std::size_t>(height), rgb.size());
  std::string header;
  AppendBigEndian(header, static_cast<std::uint32_t>(width));
  AppendBigEndian(header, static_cast<std::uint32_t>(height));
  // 8 bits, RGB, deflate, adaptive filters, not interlaced
  header += std::string_view("\x08\x02\x00\x00\x00", 5);
  std::string density;
  AppendBigEndian(density, pixels_per_metre);
  AppendBigEndian(density, pixels_per_metre);
  density += '\x01';

  std::string png(kSignature);
  AppendChunk(png, "IHDR", header);
  AppendChunk(png, "pHYs", density);
  AppendChunk(
      png, "IDAT", Deflate(FilterRows(rgb, stride, static_cast<std::size_t>(height)), level));
  AppendChunk(png, "IEND", "");
  return png;
}

}  // namespace faultlab::server

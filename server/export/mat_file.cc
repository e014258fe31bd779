#include "server/export/mat_file.h"

#include <bit>
#include <cctype>
#include <cstdint>
#include <cstring>
#include <limits>
#include <type_traits>
#include <vector>

#include "core/types/check.h"
#include "core/types/utf8.h"

namespace faultlab::server {
namespace {

static_assert(std::endian::native == std::endian::little, "the file's numbers are little endian");

// MAT-File Format (MathWorks, R2023a), tables 1-1 and 1-3.
constexpr std::uint32_t kInt8 = 1;
constexpr std::uint32_t kUint16 = 4;
constexpr std::uint32_t kInt32 = 5;
constexpr std::uint32_t kUint32 = 6;
constexpr std::uint32_t kDouble = 9;
constexpr std::uint32_t kMatrix = 14;
constexpr std::uint32_t kCharClass = 4;
constexpr std::uint32_t kDoubleClass = 6;
constexpr std::size_t kAboutBytes = 116;
constexpr std::size_t kSubsystemBytes = 8;
constexpr std::uint16_t kVersion = 0x0100;
constexpr std::size_t kNameMax = 63;
constexpr std::size_t kAlignment = 8;

template <typename Number>
void Append(std::string& out, Number value) {
  static_assert(std::is_arithmetic_v<Number>);
  char raw[sizeof value];
  std::memcpy(raw, &value, sizeof value);
  out.append(raw, sizeof raw);
}

/// Tag, data, padding to eight bytes.
void AppendElement(std::string& out, std::uint32_t type, std::string_view data) {
  LAB_CHECK(data.size() <= std::numeric_limits<std::uint32_t>::max(), data.size());
  Append(out, type);
  Append(out, static_cast<std::uint32_t>(data.size()));
  out += data;
  out.append((kAlignment - data.size() % kAlignment) % kAlignment, '\0');
}

void CheckName(std::string_view name) {
  bool good = !name.empty() && name.size() <= kNameMax &&
              std::isalpha(static_cast<unsigned char>(name.front())) != 0;
  for (const char letter : name) {
    good = good && (std::isalnum(static_cast<unsigned char>(letter)) != 0 || letter == '_');
  }
  LAB_CHECK(good, name);
}

/// The part of an array before its numbers.
std::string ArrayHead(std::string_view name,
                      std::uint32_t array_class,
                      std::size_t rows,
                      std::size_t columns) {
  CheckName(name);
  std::string flags;
  Append(flags, array_class);
  Append(flags, std::uint32_t{0});
  std::string dimensions;
  Append(dimensions, static_cast<std::int32_t>(rows));
  Append(dimensions, static_cast<std::int32_t>(columns));
  std::string head;
  AppendElement(head, kUint32, flags);
  AppendElement(head, kInt32, dimensions);
  AppendElement(head, kInt8, name);
  return head;
}

std::vector<std::uint16_t> ToUtf16(std::string_view text) {
  std::vector<std::uint16_t> out;
  while (!text.empty()) {
    const core::Utf8Character first = core::FirstCharacter(text);
    out.push_back(first.code > 0xFFFF ? std::uint16_t{'?'}
                                      : static_cast<std::uint16_t>(first.code));
    text.remove_prefix(first.bytes);
  }
  return out;
}

}  // namespace

MatFile::MatFile(Spool& out, std::string_view about) : out_(out) {
  std::string head(about.substr(0, kAboutBytes));
  head.resize(kAboutBytes, ' ');
  head.append(kSubsystemBytes, '\0');
  Append(head, kVersion);
  head += "IM";  // a machine with the same byte order reads it as "MI"
  out_.Append(head);
}

std::uint64_t MatFile::ReserveMatrix(std::string_view name, std::size_t rows, std::size_t columns) {
  const std::size_t bytes = rows * columns * sizeof(double);
  const std::string head = ArrayHead(name, kDoubleClass, rows, columns);
  constexpr std::size_t kTagBytes = 8;
  const std::size_t content = head.size() + kTagBytes + bytes;
  LAB_CHECK(content <= std::numeric_limits<std::uint32_t>::max(), name, rows, columns);
  std::string tags;
  Append(tags, kMatrix);
  Append(tags, static_cast<std::uint32_t>(content));
  tags += head;
  Append(tags, kDouble);
  Append(tags, static_cast<std::uint32_t>(bytes));
  out_.Append(tags);
  return out_.Reserve(bytes);
}

void MatFile::AddMatrix(std::string_view name,
                        std::span<const double> values,
                        std::size_t rows,
                        std::size_t columns) {
  LAB_CHECK(values.size() == rows * columns, name, values.size(), rows, columns);
  const std::uint64_t at = ReserveMatrix(name, rows, columns);
  out_.WriteAt(at, {reinterpret_cast<const char*>(values.data()), values.size_bytes()});
}

void MatFile::AddColumn(std::string_view name, std::span<const double> values) {
  AddMatrix(name, values, values.size(), 1);
}

void MatFile::AddScalar(std::string_view name, double value) {
  AddMatrix(name, {&value, 1}, 1, 1);
}

void MatFile::AddText(std::string_view name, std::string_view text) {
  const std::vector<std::uint16_t> letters = ToUtf16(text);
  std::string content = ArrayHead(name, kCharClass, letters.empty() ? 0 : 1, letters.size());
  AppendElement(
      content,
      kUint16,
      {reinterpret_cast<const char*>(letters.data()), letters.size() * sizeof letters[0]});
  std::string bytes;
  AppendElement(bytes, kMatrix, content);
  out_.Append(bytes);
}

}  // namespace faultlab::server

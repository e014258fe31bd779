#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>
#include <utility>

namespace faultlab::fuzz {

/// A condition that must hold for every input.
inline void Require(bool condition) {
  if (!condition) std::abort();
}

inline std::string_view Text(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

/// Splits an input.
class Input {
 public:
  Input(const std::uint8_t* data, std::size_t size) : left_(Text(data, size)) {}

  bool empty() const { return left_.empty(); }
  std::uint8_t Byte() {
    if (left_.empty()) return 0;
    const auto byte = static_cast<std::uint8_t>(left_.front());
    left_.remove_prefix(1);
    return byte;
  }
  /// A piece preceded by its length in 2 bytes; the rest if it is shorter.
  std::string_view Piece() {
    const std::size_t high = Byte();
    const std::size_t length = high << 8 | Byte();
    const std::string_view piece = left_.substr(0, length);
    left_.remove_prefix(piece.size());
    return piece;
  }
  std::string_view Rest() { return std::exchange(left_, {}); }

 private:
  std::string_view left_;
};

}  // namespace faultlab::fuzz

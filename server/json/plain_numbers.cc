#include "server/json/plain_numbers.h"

#include <array>
#include <boost/json.hpp>
#include <charconv>
#include <cmath>

namespace faultlab::server {
namespace {

namespace json = boost::json;

void AppendNumber(std::string& out, double number) {
  constexpr double kSmall = 1e-6;
  constexpr double kLarge = 1e15;
  const double size = std::abs(number);
  const bool fixed = size == 0.0 || (size >= kSmall && size < kLarge);
  std::array<char, 40> text;
  const auto end = std::to_chars(text.data(),
                                 text.data() + text.size(),
                                 number,
                                 fixed ? std::chars_format::fixed : std::chars_format::scientific);
  out.append(text.data(), end.ptr);
}

// NOLINTNEXTLINE(misc-no-recursion): as deep as the parser allows
void Append(std::string& out, const json::value& value) {
  const char* separator = "";
  if (const json::object* object = value.if_object()) {
    out += '{';
    for (const auto& [name, member] : *object) {
      out.append(separator).append(json::serialize(json::string(name))).append(":");
      Append(out, member);
      separator = ",";
    }
    out += '}';
  } else if (const json::array* list = value.if_array()) {
    out += '[';
    for (const json::value& entry : *list) {
      out += separator;
      Append(out, entry);
      separator = ",";
    }
    out += ']';
  } else if (const double* number = value.if_double()) {
    AppendNumber(out, *number);
  } else {
    out += json::serialize(value);
  }
}

}  // namespace

std::string WithPlainNumbers(std::string_view document) {
  boost::system::error_code failed;
  const json::value value = json::parse(document, failed);
  if (failed) return std::string(document);
  std::string out;
  Append(out, value);
  return out;
}

}  // namespace faultlab::server

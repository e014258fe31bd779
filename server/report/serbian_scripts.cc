#include "server/report/serbian_scripts.h"

#include <algorithm>
#include <array>
#include <utility>

namespace faultlab::server {
namespace {

using Pair = std::pair<std::string_view, std::string_view>;

/// Two letters that are one sound come first.
constexpr std::array<Pair, 63> kLetters = {{
    {"DŽ", "Џ"}, {"Dž", "Џ"}, {"dž", "џ"}, {"LJ", "Љ"}, {"Lj", "Љ"}, {"lj", "љ"}, {"NJ", "Њ"},
    {"Nj", "Њ"}, {"nj", "њ"}, {"A", "А"},  {"B", "Б"},  {"V", "В"},  {"G", "Г"},  {"D", "Д"},
    {"Đ", "Ђ"},  {"E", "Е"},  {"Ž", "Ж"},  {"Z", "З"},  {"I", "И"},  {"J", "Ј"},  {"K", "К"},
    {"L", "Л"},  {"M", "М"},  {"N", "Н"},  {"O", "О"},  {"P", "П"},  {"R", "Р"},  {"S", "С"},
    {"T", "Т"},  {"Ć", "Ћ"},  {"U", "У"},  {"F", "Ф"},  {"H", "Х"},  {"C", "Ц"},  {"Č", "Ч"},
    {"Š", "Ш"},  {"a", "а"},  {"b", "б"},  {"v", "в"},  {"g", "г"},  {"d", "д"},  {"đ", "ђ"},
    {"e", "е"},  {"ž", "ж"},  {"z", "з"},  {"i", "и"},  {"j", "ј"},  {"k", "к"},  {"l", "л"},
    {"m", "м"},  {"n", "н"},  {"o", "о"},  {"p", "п"},  {"r", "р"},  {"s", "с"},  {"t", "т"},
    {"ć", "ћ"},  {"u", "у"},  {"f", "ф"},  {"h", "х"},  {"c", "ц"},  {"č", "ч"},  {"š", "ш"},
}};
constexpr std::array<std::string_view, 9> kNames = {
    "CSV", "JSON", "PDF", "QR", "SHA", "SIA", "SWA", "CUSUM", "GLR"};
constexpr std::array<std::string_view, 6> kUnits = {"s", "ms", "V", "A", "Hz", "rpm"};

bool IsDigit(char c) {
  return c >= '0' && c <= '9';
}

/// Of the word at the front: ASCII letters and digits, and č, ć, đ, š and ž.
std::size_t WordBytes(std::string_view text) {
  std::size_t end = 0;
  while (end < text.size()) {
    const char c = text[end];
    const bool beyond_ascii = c == '\xC4' || c == '\xC5';
    const bool plain = IsDigit(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
    if (!plain && !beyond_ascii) break;
    end += beyond_ascii ? 2 : 1;
  }
  return std::min(end, text.size());
}

std::string Letters(std::string_view word) {
  std::string out;
  while (!word.empty()) {
    const auto found = std::ranges::find_if(
        kLetters, [&](const Pair& one) { return word.starts_with(one.first); });
    const std::size_t length = found == kLetters.end() ? 1 : found->first.size();
    out += found == kLetters.end() ? word.substr(0, 1) : found->second;
    word.remove_prefix(length);
  }
  return out;
}

bool StaysLatin(std::string_view word, bool after_number) {
  if (word.find('_') != std::string_view::npos) return true;  // a setting
  return std::ranges::find(kNames, word) != kNames.end() ||
         (after_number && std::ranges::find(kUnits, word) != kUnits.end());
}

}  // namespace

std::string ToCyrillic(std::string_view latin) {
  std::string out;
  bool after_number = false;  // a number or {0}, and a blank
  while (!latin.empty()) {
    const std::size_t length = WordBytes(latin);
    if (length == 0) {
      const char c = latin.front();
      const bool number_before = !out.empty() && (IsDigit(out.back()) || out.back() == '}');
      after_number = c == ' ' && number_before;
      out += c;
      latin.remove_prefix(1);
      continue;
    }
    const std::string_view word = latin.substr(0, length);
    if (out.ends_with(", ") && word.size() == latin.size()) after_number = true;  // "Vreme, s"
    out += StaysLatin(word, after_number) ? std::string(word) : Letters(word);
    after_number = false;
    latin.remove_prefix(length);
  }
  return out;
}

}  // namespace faultlab::server

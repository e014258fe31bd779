#include "server/report/report_words.h"

#include <array>

#include "server/report/serbian_scripts.h"

namespace faultlab::server {
std::string ReportWords::Say(std::string_view english, std::string_view serbian) const {
  if (language_ == Language::kEnglish) return std::string(english);
  return language_ == Language::kSerbian ? std::string(serbian) : ToCyrillic(serbian);
}

std::optional<Language> ParseLanguage(std::string_view name) {
  if (name == "en") return Language::kEnglish;
  if (name == "sr") return Language::kSerbian;
  if (name == "sr-Cyrl") return Language::kSerbianCyrillic;
  return std::nullopt;
}

const ReportWords& WordsOf(Language language) {
  static const std::array kAll = {ReportWords(Language::kEnglish),
                                  ReportWords(Language::kSerbian),
                                  ReportWords(Language::kSerbianCyrillic)};
  return kAll[static_cast<std::size_t>(language)];
}

std::string Fill(std::string_view text, std::initializer_list<std::string_view> values) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const std::size_t number = i + 2 < text.size() && text[i] == '{' && text[i + 2] == '}'
                                   ? static_cast<std::size_t>(text[i + 1] - '0')
                                   : values.size();
    if (number >= values.size()) {
      out += text[i];
      continue;
    }
    out += values.begin()[number];
    i += 2;
  }
  return out;
}

}  // namespace faultlab::server

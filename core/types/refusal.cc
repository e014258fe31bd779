#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>

#include "core/types/result.h"

namespace faultlab::core {
namespace {

struct Refusal {
  std::string_view reason;
  std::string_view code;
  std::string_view sentence;  ///< "There is no rig {rig}."
  std::string_view of_one;    ///< where {most} is 1; empty if the sentence is the same
};

constexpr auto kRefusals = std::to_array<Refusal>({
#include "core/types/refusals.inc"
});

/// Nothing for a word that is none: Name() of what follows the last code is "?".
constexpr std::optional<ErrorCode> CodeOf(std::string_view name) {
  for (int code = 0; Name(static_cast<ErrorCode>(code)) != "?"; ++code) {
    if (Name(static_cast<ErrorCode>(code)) == name) return static_cast<ErrorCode>(code);
  }
  return std::nullopt;
}
static_assert(std::ranges::all_of(kRefusals, [](const Refusal& each) {
  return CodeOf(each.code).has_value();
}));

/// `sentence` with each {name} replaced by the value of that parameter.
std::string Filled(std::string_view sentence, const std::vector<ErrorParameter>& parameters) {
  std::string out;
  while (true) {
    const auto open = sentence.find('{');
    const auto close = sentence.find('}', open);
    out.append(sentence.substr(0, open));
    if (close == std::string_view::npos) return out;
    const auto name = sentence.substr(open + 1, close - open - 1);
    const auto given = std::ranges::find(parameters, name, &ErrorParameter::name);
    out.append(given == parameters.end() ? name : std::string_view(given->value));
    sentence.remove_prefix(close + 1);
  }
}

std::string Plain(double number) {
  std::array<char, 32> text;
  const double size = std::abs(number);
  const bool plain = size == 0.0 || (size >= 1e-6 && size < 1e15);  // 0.00001, not 1e-05
  const auto end = std::to_chars(text.data(),
                                 text.data() + text.size(),
                                 number,
                                 plain ? std::chars_format::fixed : std::chars_format::general)
                       .ptr;
  return {text.data(), end};
}

}  // namespace

ErrorParameter::ErrorParameter(std::string_view name_, double number)
    : ErrorParameter(name_, Plain(number)) {}

Error Refuse(std::string_view reason, std::string field, std::vector<ErrorParameter> parameters) {
  const auto* known = std::ranges::find(kRefusals, reason, &Refusal::reason);
  LAB_CHECK(known != kRefusals.end(), std::string(reason));
  const bool one = !known->of_one.empty() && std::ranges::any_of(parameters, [](const auto& each) {
    return each.name == "most" && each.value == "1";
  });
  return {*CodeOf(known->code),
          Filled(one ? known->of_one : known->sentence, parameters),
          std::move(field),
          std::string(reason),
          std::move(parameters)};
}

}  // namespace faultlab::core

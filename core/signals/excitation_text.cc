#include "core/signals/excitation_text.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "core/types/number_text.h"

namespace faultlab::core {
namespace {

/// A named number of a spec.
struct Setting {
  std::string_view name;
  std::function<void(double)> set;
  double whole_max = 0.0;  ///< 0: any number, else a whole one
};

Setting Real(std::string_view name, double& target) {
  return {name, [&target](double value) { target = value; }, 0.0};
}

template <typename Integer>
Setting Whole(std::string_view name, Integer& target) {
  // Above this not every whole number is a double.
  constexpr double kWholeMax =
      std::min(1e15, static_cast<double>(std::numeric_limits<Integer>::max()));
  return {name, [&target](double value) { target = static_cast<Integer>(value); }, kWholeMax};
}

/// "a=1,b=2" into the settings.
Status Apply(std::string_view text, const std::vector<Setting>& settings) {
  const auto refuse = [](const std::string& what) {
    return Error{ErrorCode::kInvalid, "excitation: " + what, "excitation"};
  };
  std::vector<std::string_view> given;
  while (!text.empty()) {
    const std::size_t comma = text.find(',');
    const std::string_view part = text.substr(0, comma);
    text.remove_prefix(comma == std::string_view::npos ? text.size() : comma + 1);
    const std::size_t equals = part.find('=');
    const std::string_view name = part.substr(0, equals);
    const Setting* found = nullptr;
    std::string names;
    for (const Setting& setting : settings) {
      names += (names.empty() ? "" : ", ") + std::string(setting.name);
      found = setting.name == name ? &setting : found;
    }
    if (found == nullptr || equals == std::string_view::npos) {
      return refuse("'" + std::string(part) + "' is not NAME=NUMBER with one of " + names);
    }
    if (std::ranges::find(given, name) != given.end()) {
      return refuse(std::string(name) + " is given twice");
    }
    given.push_back(name);
    const std::optional<double> value = ParseNumber(part.substr(equals + 1));
    const bool whole = found->whole_max > 0.0;
    if (!value ||
        (whole && (std::floor(*value) != *value || *value < 0.0 || *value > found->whole_max))) {
      return refuse(std::string(name) + " must be a " + (whole ? "whole number" : "number") +
                    ", found '" + std::string(part.substr(equals + 1)) + "'");
    }
    found->set(*value);
  }
  return Done{};
}

template <typename Spec>
Result<ExcitationSpec> Filled(Spec& spec,
                              std::string_view rest,
                              const std::vector<Setting>& settings) {
  TRY_DONE(Apply(rest, settings));
  return ExcitationSpec(spec);
}

}  // namespace

Result<ExcitationSpec> ParseExcitation(std::string_view text, std::uint64_t seed) {
  const std::size_t colon = text.find(':');
  const std::string_view kind = text.substr(0, colon);
  const std::string_view rest =
      colon == std::string_view::npos ? std::string_view() : text.substr(colon + 1);
  if (kind == "prbs") {
    PrbsSpec spec;
    spec.seed = seed;
    return Filled(spec,
                  rest,
                  {Real("low", spec.low_v),
                   Real("high", spec.high_v),
                   Real("clock", spec.clock_s),
                   Whole("order", spec.order),
                   Whole("seed", spec.seed)});
  }
  if (kind == "step") {
    StepSpec spec;
    return Filled(
        spec, rest, {Real("low", spec.low_v), Real("high", spec.high_v), Real("at", spec.at_s)});
  }
  if (kind == "multisine") {
    MultisineSpec spec;
    spec.seed = seed;
    return Filled(spec,
                  rest,
                  {Real("offset", spec.offset_v),
                   Real("amplitude", spec.amplitude_v),
                   Whole("lines", spec.lines),
                   Real("base", spec.base_period_s),
                   Whole("seed", spec.seed)});
  }
  if (kind == "chirp") {
    ChirpSpec spec;
    return Filled(spec,
                  rest,
                  {Real("offset", spec.offset_v),
                   Real("amplitude", spec.amplitude_v),
                   Real("from", spec.from_hz),
                   Real("to", spec.to_hz)});
  }
  return Error{ErrorCode::kInvalid,
               "excitation '" + std::string(text) +
                   "' is not known, expected prbs, step, multisine or chirp",
               "excitation"};
}

}  // namespace faultlab::core

// The short texts of command lines, CSV comments and request targets. The first byte selects one.
#include <cmath>

#include "core/signals/excitation.h"
#include "core/signals/excitation_text.h"
#include "core/types/number_text.h"
#include "server/csv/fault_text.h"
#include "tests/fuzz/fuzz_input.h"
#include "tests/paper_bench.h"

using namespace faultlab;  // NOLINT(google-build-using-namespace)
using fuzz::Require;

namespace {

bool Same(const core::Fault& a, const core::Fault& b) {
  return a.component == b.component && a.value == b.value && a.at_s == b.at_s && a.kind == b.kind &&
         (a.kind == core::FaultKind::kAbrupt || a.until_s == b.until_s);
}

void CheckFault(std::string_view text) {
  const auto fault = server::ParseFault(text, faultlab::paper::Bench());
  if (!fault) return Require(!fault.error().message.empty());
  const auto again =
      server::ParseFault(server::FormatFault(fault.value()), faultlab::paper::Bench());
  Require(again.ok() && Same(again.value(), fault.value()));
  const auto comments =
      server::FaultsInComments({server::FaultComment(fault.value())}, faultlab::paper::Bench());
  Require(comments.size() == 1 && Same(comments[0], fault.value()));
}

void CheckExcitation(std::string_view text) {
  const auto spec = core::ParseExcitation(text, 1);
  if (!spec) return Require(!spec.error().message.empty());
  // Computes a short excitation from an accepted text: values, or a refusal.
  const auto volts = core::Generate(spec.value(), 0.01, 64);
  if (!volts) return Require(!volts.error().message.empty());
  for (const double volt : volts.value()) Require(std::isfinite(volt));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input input(data, size);
  const int which = input.Byte() % 3;
  const std::string_view text = input.Rest();
  if (which == 0) {
    CheckFault(text);
  } else if (which == 1) {
    CheckExcitation(text);
  } else {
    if (const auto number = core::ParseNumber(text)) Require(std::isfinite(*number));
    if (const auto value = core::ParseValue(text)) Require(std::isfinite(*value));
  }
  return 0;
}

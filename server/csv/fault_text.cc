#include "server/csv/fault_text.h"

#include "core/types/number_text.h"

namespace faultlab::server {
namespace {

using core::Error;
using core::ErrorCode;
using core::Fault;
using core::FaultKind;

constexpr std::string_view kCommentMark = "fault ";

std::string SymbolsOf(const core::Bench& bench) {
  std::string symbols;
  for (const core::ComponentInfo& part : bench.parts) {
    symbols += (symbols.empty() ? "" : ", ") + part.symbol;
  }
  return symbols;
}

struct Separator {
  std::string_view text;
  FaultKind kind;
};
constexpr Separator kSeparators[] = {{"..", FaultKind::kDrift}, {"to", FaultKind::kIntermittent}};

}  // namespace

core::Result<Fault> ParseFault(std::string_view text, const core::Bench& bench) {
  const auto refuse = [text](const std::string& what) {
    return Error{
        ErrorCode::kInvalid, "fault '" + std::string(text) + "': " + what, "fault", "internal"};
  };
  const std::size_t equals = text.find('=');
  const std::size_t at = text.find('@');
  if (equals == std::string_view::npos || at == std::string_view::npos || at < equals) {
    return refuse("expected COMPONENT=VALUE@SECONDS, for example R1=100@10");
  }
  Fault fault;
  const std::string_view name = text.substr(0, equals);
  const std::optional<core::Component> component = bench.Find(name);
  if (!component) {
    return refuse("unknown component '" + std::string(name) + "', expected one of " +
                  SymbolsOf(bench));
  }
  fault.component = *component;
  const std::string_view value_text = text.substr(equals + 1, at - equals - 1);
  const std::optional<double> value = core::ParseValue(value_text);
  if (!value || *value <= 0.0) {
    return refuse("value '" + std::string(value_text) + "' must be a number above 0 in " +
                  std::string(core::Unit(*component)));
  }
  fault.value = *value;
  std::string_view when = text.substr(at + 1);
  for (const Separator& separator : kSeparators) {
    const std::size_t cut = when.find(separator.text);
    if (cut == std::string_view::npos) {
      continue;
    }
    const std::optional<double> until = core::ParseNumber(when.substr(cut + separator.text.size()));
    if (!until) {
      return refuse("time after '" + std::string(separator.text) + "' must be a number of seconds");
    }
    fault.kind = separator.kind;
    fault.until_s = *until;
    when = when.substr(0, cut);
    break;
  }
  const std::optional<double> at_s = core::ParseNumber(when);
  if (!at_s || *at_s < 0.0) {
    return refuse("time '" + std::string(when) + "' must be a number of seconds, 0 or more");
  }
  fault.at_s = *at_s;
  if (fault.kind != FaultKind::kAbrupt && fault.until_s <= fault.at_s) {
    return refuse("the end must come after the start");
  }
  return fault;
}

std::string FormatFault(const Fault& fault) {
  std::string text(core::Name(fault.component));
  text += "=" + core::Shortest(fault.value) + "@" + core::Shortest(fault.at_s);
  for (const Separator& separator : kSeparators) {
    if (separator.kind == fault.kind) {
      text += std::string(separator.text) + core::Shortest(fault.until_s);
    }
  }
  return text;
}

std::string FaultComment(const Fault& fault) {
  return std::string(kCommentMark) + FormatFault(fault);
}

std::vector<Fault> FaultsInComments(const std::vector<std::string>& comments,
                                    const core::Bench& bench) {
  std::vector<Fault> faults;
  for (const std::string& comment : comments) {
    if (!comment.starts_with(kCommentMark)) {
      continue;
    }
    const core::Result<Fault> fault =
        ParseFault(std::string_view(comment).substr(kCommentMark.size()), bench);
    if (fault) {
      faults.push_back(fault.value());
    }
  }
  return faults;
}

}  // namespace faultlab::server

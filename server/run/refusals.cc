#include "server/run/refusals.h"

#include <utility>

namespace faultlab::server::refusal {

using core::Error;
using core::ErrorCode;

Error RigRefused(const std::string& rig, const hardware::RemoteRigInfo& why) {
  return {ErrorCode::kUnavailable,
          "Rig '" + rig + "' cannot be used now: " + why.refusal_text + ".",
          "/rig",
          std::string(hardware::Name(*why.refusal)),
          {{"rig", rig}}};
}

Error OfLease(const std::string& rig, Error error) {
  const bool held = error.field == hardware::kLeaseField && error.code == ErrorCode::kBusy;
  if (!held && !error.reason.empty()) return error;
  error.reason =
      held ? std::string(hardware::Name(hardware::RigRefusal::kHeldElsewhere)) : "rig_refuses";
  error.parameters = {{"rig", rig}};
  return error;
}

Error NoComponent(const core::Bench& bench, std::string_view symbol) {
  std::string known;
  for (const core::Component each : bench.components()) {
    known += (known.empty() ? "" : ", ") + std::string(core::Name(each));
  }
  return core::Refuse("no_component", "component", {{"component", symbol}, {"known", known}});
}

Error At(Error error, std::string field) {
  error.field = std::move(field);
  return error;
}

Error In(Error error, std::string field) {
  error.code = ErrorCode::kInvalid;
  return At(std::move(error), std::move(field));
}

}  // namespace faultlab::server::refusal

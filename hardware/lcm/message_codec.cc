#include "hardware/lcm/message_codec.h"

namespace faultlab::hardware {

void Encode(const core::Sample& sample, faultlab_msgs::sample_t& out) {
  CopyReadings(sample, out);
}

core::Sample Decode(const faultlab_msgs::sample_t& in) {
  core::Sample sample;
  CopyReadings(in, sample);
  return sample;
}

void Encode(const core::Frame& frame, faultlab_msgs::estimates_t& out) {
  out.index = frame.sample.index;
  out.t_s = frame.sample.t_s;
  out.count = core::kEstimatorCount;
  out.estimates.resize(core::kEstimatorCount);
  for (std::size_t i = 0; i < core::kEstimatorCount; ++i) {
    const core::Estimate<3>& from = frame.estimates[i];
    faultlab_msgs::estimate_t& to = out.estimates[i];
    to.estimator = core::kEstimatorShapes[i].name;
    to.status = static_cast<std::int8_t>(from.status);
    to.age_samples = from.age_samples;
    for (std::size_t p = 0; p < 3; ++p) {
      to.theta[p] = from.theta[p];
      to.sigma[p] = from.sigma[p];
    }
    to.sse = from.sse;
    to.condition = from.condition;
  }
}

void Encode(const RigEvent& event, faultlab_msgs::event_t& out) {
  out.index = event.index;
  out.kind = Name(event.kind);
  out.component =
      NamesComponent(event.kind) && event.component.exists() ? core::Name(event.component) : "";
  out.value = event.value;
  out.text = event.text;
}

std::optional<RigEvent> Decode(const faultlab_msgs::event_t& in, const core::Bench& bench) {
  RigEvent event;
  event.index = in.index;
  event.value = in.value;
  event.text = in.text;
  if (!in.component.empty()) {
    const std::optional<core::Component> component = bench.Find(in.component);
    if (!component) return std::nullopt;
    event.component = *component;
  }
  const std::optional<RigEventKind> kind = ParseRigEventKind(in.kind);
  if (!kind) return std::nullopt;
  event.kind = *kind;
  return event;
}

}  // namespace faultlab::hardware

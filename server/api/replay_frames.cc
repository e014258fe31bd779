#include "server/api/replay_frames.h"

#include "core/diagnosis/pipeline.h"

namespace faultlab::server {

void ReplayFrames(std::span<const core::Sample> samples,
                  double period_s,
                  const std::function<void(const core::Frame&)>& each) {
  core::PipelineConfig config;
  config.period_s = period_s;
  core::Pipeline pipeline(config);
  for (const core::Sample& sample : samples) each(pipeline.Push(sample));
}

}  // namespace faultlab::server

#pragma once

#include <boost/json/object.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/signals/excitation.h"
#include "core/types/fault.h"
#include "core/types/result.h"
#include "hardware/rig.h"
#include "hardware/run_plan.h"

namespace faultlab::server {

inline constexpr double kRunSecondsMin = 1.0;
inline constexpr double kRunSecondsMax = 600.0;
inline constexpr std::int64_t kRunSamplesMax = 60'000;
inline constexpr std::size_t kRunFaultsMax = 64;
inline constexpr std::size_t kNameBytesMax = 200;

/// POST /api/v1/runs, with the defaults of the paper's experiment filled in.
struct RunBody {
  std::string rig;  ///< empty: any free simulated rig
  core::ExcitationSpec excitation;
  double period_s = core::kSamplePeriodSeconds;
  double duration_s = 20.0;
  std::vector<core::Fault> faults;
  std::uint64_t seed = 1;
  std::string recording;  ///< not empty: replay this one; excitation and faults are its own
  std::string name;
};

/// Refuses unknown fields, wrong kinds and values that no rig could take; Error.field is a JSON
/// pointer.
core::Result<RunBody> ParseRunBody(std::string_view text, std::uint64_t default_seed);

/// The plan for this rig. Refuses what is outside its envelope or what it cannot switch, by field.
core::Result<hardware::RunPlan> ResolvePlan(const RunBody& body,
                                            const hardware::RigDescription& rig);

/// The resolved plan as the API shows and stores it: every field of the request with its value.
boost::json::object PlanToJson(const RunBody& body, const hardware::RigDescription& rig);
/// The faults of a stored plan; empty when it has none.
std::vector<core::Fault> FaultsOfPlan(std::string_view plan_json);

}  // namespace faultlab::server

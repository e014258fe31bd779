#include "core/plant/profile.h"

namespace faultlab::core {

BenchProfile BenchProfileBench() {
  BenchProfile profile;
  profile.name = "bench";
  profile.delta_s = 9.5e-3;
  profile.friction.mc_nm = 0.33e-3;
  profile.friction.ms_nm = 0.40e-3;
  profile.friction.noise_rms_nm = 0.02e-3;
  profile.friction.noise_tau_s = 0.5;
  profile.noise = {.um_v = 15e-3, .ua_v = 15e-3, .ia_a = 1e-3, .n_rpm = 0.5};
  return profile;
}

BenchProfile BenchProfileMultisim() {
  BenchProfile profile;
  profile.name = "multisim";
  profile.delta_s = 4.5e-3;
  profile.noise = {.um_v = 2e-3, .ua_v = 2e-3, .ia_a = 0.2e-3, .n_rpm = 0.1};
  return profile;
}

Result<BenchProfile> FindBenchProfile(std::string_view name) {
  if (name == "bench") {
    return BenchProfileBench();
  }
  if (name == "multisim") {
    return BenchProfileMultisim();
  }
  return Error{ErrorCode::kNotFound,
               "No profile \"" + std::string(name) + "\": there are \"bench\" and \"multisim\".",
               "profile"};
}

}  // namespace faultlab::core

#pragma once

#include <array>
#include <string_view>

namespace faultlab::core {

/// What `tests/bench/method_tunings` has found on the paper's bench; its seeds are not those of any
/// figure. The rule is in core/methods/README.md.
struct MethodTuning {
  std::string_view name;
  double tuning;
  double level;            ///< one false alarm a day, at 100 samples a second
  double level_all = 0.0;  ///< the same with all channels, of a method that reads them; 0: level
};

inline constexpr std::array kMethodTunings = {
    MethodTuning{"ls", 100, 26.8405},          MethodTuning{"rls", 0.95, 110.275},
    MethodTuning{"rls-reset", 0.99, 59.9202},  MethodTuning{"ekf-bank", 0.5, 129.032},
    MethodTuning{"ekf-joint", 0.5, 17.502},    MethodTuning{"ukf-bank", 2, 129.032},
    MethodTuning{"ukf-joint", 0.5, 17.5007},   MethodTuning{"agt", 4, 148.695},
    MethodTuning{"ga", 400, 1.9469},           MethodTuning{"pso", 400, 1.9469},
    MethodTuning{"woa", 100, 1.9469},          MethodTuning{"nn", 3, -0.0397085},
    MethodTuning{"fuzzy", 20, 33.0192},        MethodTuning{"parity", 50, 43.4924},
    MethodTuning{"luenberger", 0.95, 117.638}, MethodTuning{"kalman", 0.5, 131.575},
    MethodTuning{"sliding", 2, 137.913},       MethodTuning{"signal", 64, 104.282, 168.695},
    MethodTuning{"swa", 50, 6.72406},          MethodTuning{"sia", 100, 15.256},
};

}  // namespace faultlab::core

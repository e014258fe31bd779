#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace faultlab::core {

/// What a publication prints about one fault of this class of benches, as printed.
struct PublishedFault {
  std::string component;        ///< its symbol
  double value = 0.0;           ///< SI unit
  std::array<double, 3> swa{};  ///< b0d, b1d, a1d
  std::array<double, 3> sia{};  ///< b0, b1, a1
  double identified = 0.0;      ///< the value that it found, SI unit
  std::array<int, 3> tables{};  ///< in which these three are printed; 0: in none
};

struct Publication {
  std::string source;  ///< "doi:10.3390/app15158322"; empty: nothing was published
  /// Coulomb frictions (Nm) of the models that it compares with measurements.
  std::vector<double> mc_nm;
  std::vector<PublishedFault> faults;

  /// nullptr when it prints nothing about this fault.
  const PublishedFault* Find(std::string_view component, double value) const {
    for (const PublishedFault& fault : faults) {
      if (fault.component == component && fault.value == value) return &fault;
    }
    return nullptr;
  }
};

}  // namespace faultlab::core

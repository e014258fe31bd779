#pragma once

#include <array>
#include <string_view>

namespace faultlab::core {

/// Percent of Tables 13-20: simulated outputs of five models against the measured one.
struct PaperFits {
  double swa;
  double sia;
  double mc_0;
  double mc_048;  ///< Eq. (3) with Mc = 0.48 mNm
  double mc_033;  ///< Eq. (3) with Mc = 0.33 mNm
};

/// The fits that the paper prints for one of its 18 faults, as printed, errata included. What a
/// description can hold, the estimates and the value found, stands in benches/paper.toml.
/// Source: Antic et al., Applied Sciences 15 (2025) 8322, doi:10.3390/app15158322.
struct PaperFault {
  std::string_view component;  ///< its symbol
  double value;                ///< SI unit
  int fit_table;               ///< 14..20
  PaperFits fits;
};

inline constexpr int kPaperFaultCount = 18;
/// In the paper's order: R1, R9, R12, C8, Ra, J, B.
const std::array<PaperFault, kPaperFaultCount>& PrintedFaults();
/// Table 13: the healthy rig.
const PaperFits& PaperNominalFits();

inline constexpr int kPaperTableFirst = 3;
inline constexpr int kPaperTableLast = 20;
/// "Amplifier parameters by SWA, faults in R1 and R9", for table 3..20.
const char* PaperTableTitle(int table);

}  // namespace faultlab::core

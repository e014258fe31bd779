#pragma once

#include <array>
#include <span>

#include "core/types/component.h"

namespace faultlab::core {

/// Percent of Tables 13-20: simulated outputs of five models against the measured one.
struct PaperFits {
  double swa;
  double sia;
  double mc_0;
  double mc_048;  ///< Eq. (3) with Mc = 0.48 mNm
  double mc_033;  ///< Eq. (3) with Mc = 0.33 mNm
};

/// What the paper prints about one of its 18 faults, as printed, errata included.
/// Source: Antic et al., Applied Sciences 15 (2025) 8322, doi:10.3390/app15158322.
struct PaperFault {
  Component component;
  double value;               ///< SI unit
  int swa_table;              ///< 3..6
  std::array<double, 3> swa;  ///< b0d, b1d, a1d
  int sia_table;              ///< 7..10
  std::array<double, 3> sia;  ///< b0, b1, a1
  int identified_table;       ///< 11, 12
  double identified;          ///< SI unit
  int fit_table;              ///< 14..20
  PaperFits fits;
};

inline constexpr int kPaperFaultCount = 18;
/// In the paper's order: R1, R9, R12, C8, Ra, J, B.
const std::array<PaperFault, kPaperFaultCount>& PrintedFaults();
/// Table 13: before any fault.
const PaperFits& PaperNominalFits();

inline constexpr int kPaperTableFirst = 3;
inline constexpr int kPaperTableLast = 20;
/// "Amplifier parameters by SWA, faults in R1 and R9", for table 3..20.
const char* PaperTableTitle(int table);

}  // namespace faultlab::core

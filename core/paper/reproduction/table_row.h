#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/types/component.h"

namespace faultlab::core {

/// The component and value of a row; none in Table 13 (healthy rig).
struct TableFault {
  Component component{};
  double value = 0.0;
};

/// One number of the paper beside ours.
struct TableRow {
  int table = 0;  ///< 3..20
  std::optional<TableFault> fault;
  /// Tables 3-6 "b0d", "b1d", "a1d"; 7-10 "b0", "b1", "a1"; 11, 12 "Eq. 42" (the paper's way, from
  /// exact coefficients) and "isolation fit" (ours, from the record); 13-20 "swa", "sia", "mc_0",
  /// "mc_0.48mNm", "mc_0.33mNm".
  std::string name;
  double paper = 0.0;  ///< as printed; Table 7's two exchanged rows are put back
  double ours = 0.0;
  std::optional<double> truth;  ///< the value in the simulated rig (Tables 11, 12)
  std::string erratum;          ///< why this printed number should not be trusted; usually empty
  bool compared = true;         ///< counts in the summary; false for a row with an erratum
};

struct PaperTable {
  int table = 0;
  std::string title;
  std::string unit;      ///< "" , "SI", "percent"
  std::string profile;   ///< the simulator of our numbers
  std::string settings;  ///< estimator and window, one line
  std::vector<TableRow> rows;
  double mean_relative_error = 0.0;  ///< mean |ours/paper - 1| of compared rows; 0 in 13..20
  double mean_difference = 0.0;      ///< mean |ours - paper| of compared rows, percent; 0 in 3..12
};

}  // namespace faultlab::core

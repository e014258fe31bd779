#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/types/component.h"
#include "core/types/fault.h"
#include "core/types/sample.h"

namespace faultlab::core {

/// The component and value of a row; nothing in Table 13 (before any fault).
struct TableFault {
  Component component = Component::kR1;
  double value = 0.0;
};

/// One number of the paper beside ours.
struct TableRow {
  int table = 0;  ///< 3..20
  std::optional<TableFault> fault;
  std::string name;    ///< "b0d", "b0", "R1", "swa", "mc_0.33mNm", ..
  double paper = 0.0;  ///< as printed, errata included
  double ours = 0.0;
  std::string erratum;   ///< why this printed number should not be trusted; empty mostly
  bool compared = true;  ///< counts in the summary: false where an erratum forbids it
};

struct PaperTable {
  int table = 0;
  std::string title;
  std::string unit;      ///< "" , "SI", "percent"
  std::string profile;   ///< the rig that our numbers come from
  std::string settings;  ///< estimator and window, one line
  std::vector<TableRow> rows;
  double mean_relative_error = 0.0;  ///< |ours/paper - 1| over compared rows (tables 3..12)
  double mean_difference = 0.0;      ///< |ours - paper| over compared rows (tables 13..20)
};

struct ReproductionOptions {
  std::uint64_t seed = 1;
  /// Monte Carlo repetitions per fault whose median is `ours`; 1 = one record as the paper's.
  int repetitions = 1;
};

/// Same-kind fit of our own estimator on the same record, beside the true model's.
struct FitRow {
  std::optional<TableFault> fault;
  double paper_best_percent = 0.0;
  double ours_percent = 0.0;
  double truth_percent = 0.0;
};

struct ReproductionSummary {
  double tables_7_8_mean_relative_error = 0.0;
  double tables_5_6_mean_relative_error = 0.0;  ///< without J = 1.43e-8, diagnosis section 7
  double nominal_fit_swa_percent = 0.0;
  double nominal_fit_sia_percent = 0.0;
  int rows = 0;
  int rows_with_erratum = 0;
};

struct Reproduction {
  std::vector<PaperTable> tables;  ///< 3..20 in order
  std::vector<FitRow> fits;
  ReproductionSummary summary;
};

/// Simulates the paper's 18 faults (bench profile for R1, R9, R12, C8, multisim for Ra, J, B) and
/// computes Tables 3-20. One fixed configuration per profile, no tuning by row. Under a second.
Reproduction Reproduce(const ReproductionOptions& options);

/// The record behind one row: for the figures.
std::vector<Sample> PaperRecord(const std::optional<TableFault>& fault, std::uint64_t seed);

}  // namespace faultlab::core

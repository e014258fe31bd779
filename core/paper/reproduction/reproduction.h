#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/paper/reproduction/table_row.h"
#include "core/types/sample.h"

namespace faultlab::core {

struct ReproductionOptions {
  std::uint64_t seed = 1;
  /// Records simulated for each fault, seeds seed, seed + 1, ..; the tables show their medians, so
  /// that one noise does not decide a comparison with the paper. Isolation runs on the first.
  int repetitions = 9;
};

/// Fit of our own identified model over the faulty half of the record, beside the true model's.
struct FitRow {
  std::optional<TableFault> fault;  ///< nothing: the healthy record
  double paper_percent = 0.0;       ///< better one of the paper's SWA and SIA
  double ours_percent = 0.0;        ///< calibrated on 0.5 s .. 5 s, isolated and identified
  double truth_percent = 0.0;       ///< simulated with the true parameters: what noise allows
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
/// computes Tables 3-20. One fixed configuration per profile, no tuning by row: SWA K = 100, SIA
/// (K, m) = (500, 20) in the paper's rule, both with the rig's output noise subtracted from the
/// normal equations, `ours` = median over the settled part of the records. A few seconds.
Reproduction Reproduce(const ReproductionOptions& options);

/// The record behind one row: for the figures.
std::vector<Sample> PaperRecord(const std::optional<TableFault>& fault, std::uint64_t seed);

}  // namespace faultlab::core

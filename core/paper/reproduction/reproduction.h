#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/bench/bench.h"
#include "core/paper/model_comparison.h"
#include "core/paper/reproduction/table_row.h"
#include "core/types/sample.h"

namespace faultlab::core {

struct ReproductionOptions {
  const Bench* bench = nullptr;  ///< the paper's bench; never null
  std::uint64_t seed = 1;
  /// Records simulated for each fault, with seeds seed, seed + 1, ..; the tables show their
  /// medians, so that the comparison does not depend on one noise sequence. Isolation runs on the
  /// first record.
  int repetitions = 9;
};

/// Fit of our own identified model over the faulty half of the record, beside the true model's.
struct FitRow {
  std::optional<TableFault> fault;  ///< none: the healthy record
  double paper_percent = 0.0;       ///< better one of the paper's SWA and SIA
  double ours_percent = 0.0;        ///< calibrated on 0.5 s .. 5 s, isolated and identified
  double truth_percent = 0.0;       ///< fit of the true parameters, limited by noise only
};

struct ReproductionSummary {
  double tables_7_8_mean_relative_error = 0.0;
  double tables_5_6_mean_relative_error = 0.0;  ///< without rows that have an erratum
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

/// What a bench lacks to be the one of the printed tables: one of their components, the paper's
/// period or one of the two simulators. Empty: nothing.
std::string MissingForTables(const Bench& bench);

/// Simulates the paper's 18 faults (bench profile for R1, R9, R12, C8, multisim for Ra, J, B) and
/// computes Tables 3-20. One fixed configuration per profile, without tuning by row: SWA K = 100,
/// SIA (K, m) = (500, 20) in the paper's rule, both with the rig's output noise subtracted from the
/// normal equations, `ours` = median over the settled part of the records. Takes a few seconds.
/// Contract: the bench misses nothing for the tables.
Reproduction Reproduce(const ReproductionOptions& options);

/// The five models of one row of Tables 13-20, as Figure 23 shows them.
struct PaperComparison {
  std::vector<Sample> stretch;  ///< from the fault on; of the healthy record, before 10 s
  std::vector<ComparedFit> models;
};
/// Of the first record: where there are several, the tables have the medians of the fits.
/// Contract: as Reproduce.
PaperComparison ComparePaperModels(const Bench& bench,
                                   const std::optional<TableFault>& fault,
                                   std::uint64_t seed);

/// The record behind one row, for the figures.
/// Contract: as Reproduce.
std::vector<Sample> PaperRecord(const Bench& bench,
                                const std::optional<TableFault>& fault,
                                std::uint64_t seed);

}  // namespace faultlab::core

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/paper/reproduction/table_row.h"

namespace faultlab::core {

/// Collects the rows of Tables 3..20.
class ReproducedTables {
 public:
  ReproducedTables();

  /// Appends a row with its erratum; a row with an erratum is not compared. The reference is valid
  /// until the next Add.
  TableRow& Add(int table,
                const std::optional<TableFault>& fault,
                std::string name,
                double paper,
                double ours);
  PaperTable& Of(int table);

  /// The tables with the means of their compared rows; nothing may be added afterwards.
  std::vector<PaperTable> Finish();

 private:
  std::vector<PaperTable> tables_;
};

/// Mean of |ours/paper - 1| over the rows of two tables.
double MeanRelativeError(const std::vector<PaperTable>& tables,
                         int first,
                         int second,
                         bool without_smallest_inertia);

}  // namespace faultlab::core

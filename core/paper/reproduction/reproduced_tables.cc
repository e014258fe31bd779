#include "core/paper/reproduction/reproduced_tables.h"

#include <cmath>
#include <cstddef>
#include <utility>

#include "core/paper/paper_tables.h"
#include "core/paper/reproduction/errata.h"

namespace faultlab::core {
namespace {

PaperTable MakeTable(int table) {
  PaperTable made;
  made.table = table;
  made.title = PaperTableTitle(table);
  const bool motor =
      table == 5 || table == 6 || table == 9 || table == 10 || table == 12 || table >= 18;
  made.profile = motor ? "multisim" : "bench";
  if (table <= 6) {
    made.settings = "SWA K=100, output noise subtracted, median of settled estimates";
  } else if (table <= 10) {
    made.settings =
        "SIA K=500 m=20, paper rule, output noise subtracted, median of settled estimates";
  } else if (table <= 12) {
    made.unit = "SI";
    made.settings =
        "Eq. 42: one exact Jacobian column on exact Eq. 4 coefficients; isolation fit: from the "
        "record";
  } else {
    made.unit = "percent";
    made.settings = table == 13 ? "simulated output over 0.5 s .. 10 s, delta = 0 as in the paper"
                                : "simulated output over 10 s .. 20 s, delta = 0 as in the paper";
  }
  return made;
}

}  // namespace

ReproducedTables::ReproducedTables() {
  for (int table = kPaperTableFirst; table <= kPaperTableLast; ++table) {
    tables_.push_back(MakeTable(table));
  }
}

TableRow& ReproducedTables::Add(int table,
                                const std::optional<TableFault>& fault,
                                std::string name,
                                double paper,
                                double ours) {
  TableRow row;
  row.table = table;
  row.fault = fault;
  row.erratum = ErratumOf(table, fault, name);
  row.compared = row.erratum.empty();
  row.name = std::move(name);
  row.paper = paper;
  row.ours = ours;
  return Of(table).rows.emplace_back(std::move(row));
}

PaperTable& ReproducedTables::Of(int table) {
  return tables_.at(static_cast<std::size_t>(table - kPaperTableFirst));
}

std::vector<PaperTable> ReproducedTables::Finish() {
  for (PaperTable& table : tables_) {
    double error = 0.0;
    int rows = 0;
    for (const TableRow& row : table.rows) {
      if (row.compared) {
        error += table.table <= 12 ? std::abs(row.ours / row.paper - 1.0)
                                   : std::abs(row.ours - row.paper);
        ++rows;
      }
    }
    (table.table <= 12 ? table.mean_relative_error : table.mean_difference) =
        rows > 0 ? error / rows : 0.0;
  }
  return std::move(tables_);
}

/// Mean of |ours/paper - 1| over the rows of two tables.
double MeanRelativeError(const std::vector<PaperTable>& tables,
                         int first,
                         int second,
                         bool without_smallest_inertia) {
  double error = 0.0;
  int rows = 0;
  for (const PaperTable& table : tables) {
    for (const TableRow& row : table.rows) {
      const bool smallest =
          row.fault && Name(row.fault->component) == "J" && row.fault->value < 1e-7;
      if ((row.table == first || row.table == second) && !(without_smallest_inertia && smallest)) {
        error += std::abs(row.ours / row.paper - 1.0);
        ++rows;
      }
    }
  }
  return error / rows;
}

}  // namespace faultlab::core

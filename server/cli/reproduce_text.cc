#include <algorithm>
#include <cmath>
#include <vector>

#include "core/types/number_text.h"
#include "server/cli/reproduce.h"

namespace faultlab::server {
namespace {

constexpr std::size_t kFaultWidth = 28;
constexpr std::size_t kCellWidth = 10;
constexpr int kDigits = 4;
constexpr int kValueDigits = 6;  // "33000", not "3.3e+04"

std::string Digits(double value, int digits = kDigits) {
  if (!std::isfinite(value)) {
    return "-";
  }
  return core::Format("%.*g", digits, value);
}

std::string Left(std::string text, std::size_t width) {
  text.resize(std::max(text.size() + 1, width), ' ');
  return text;
}

std::string Right(const std::string& text, std::size_t width) {
  return std::string(width > text.size() ? width - text.size() : 1, ' ') + text;
}

std::string FaultText(const std::optional<core::TableFault>& fault) {
  if (!fault) {
    return "no fault";
  }
  return std::string(core::Name(fault->component)) + " = " + Digits(fault->value, kValueDigits) +
         " " + std::string(core::Unit(fault->component));
}

bool SameFault(const std::optional<core::TableFault>& a, const std::optional<core::TableFault>& b) {
  if (!a || !b) {
    return !a && !b;
  }
  return a->component == b->component && a->value == b->value;
}

std::vector<std::string> ColumnNames(const core::PaperTable& table) {
  std::vector<std::string> names;
  for (const core::TableRow& row : table.rows) {
    if (std::ranges::find(names, row.name) == names.end()) {
      names.push_back(row.name);
    }
  }
  return names;
}

/// A wide table is split: at most three pairs of columns fit the width of a terminal.
constexpr std::size_t kPairsMax = 3;

class TableText {
 public:
  explicit TableText(const core::PaperTable& table) : table_(table), names_(ColumnNames(table)) {}

  std::string Run() {
    out_ += "Table " + std::to_string(table_.table) + "  " + table_.title + "\n  " +
            table_.profile + " profile, " + table_.settings + "\n";
    for (std::size_t first = 0; first < names_.size(); first += kPairsMax) {
      Block(first, std::min(names_.size(), first + kPairsMax));
    }
    Notes();
    return std::move(out_);
  }

 private:
  void Block(std::size_t first, std::size_t last) {
    out_ += Left("", kFaultWidth);
    for (std::size_t i = first; i < last; ++i) {
      const std::string name = names_[i].substr(0, 2 * kCellWidth - 2);
      out_ += Right(name, 2 * kCellWidth) + "  ";
    }
    out_ += "\n" + Left("", kFaultWidth);
    for (std::size_t i = first; i < last; ++i) {
      out_ += Right("paper", kCellWidth) + Right("ours", kCellWidth) + "  ";
    }
    out_ += '\n';
    for (std::size_t row = 0; row < table_.rows.size(); ++row) {
      const bool seen = std::any_of(table_.rows.begin(),
                                    table_.rows.begin() + static_cast<std::ptrdiff_t>(row),
                                    [&](const core::TableRow& earlier) {
                                      return SameFault(earlier.fault, table_.rows[row].fault);
                                    });
      if (!seen) {
        FaultLine(table_.rows[row].fault, first, last);
      }
    }
  }

  void FaultLine(const std::optional<core::TableFault>& fault,
                 std::size_t first,
                 std::size_t last) {
    out_ += Left("  " + FaultText(fault), kFaultWidth);
    for (std::size_t i = first; i < last; ++i) {
      const auto row = std::ranges::find_if(table_.rows, [&](const core::TableRow& one) {
        return one.name == names_[i] && SameFault(one.fault, fault);
      });
      if (row == table_.rows.end()) {
        out_ += Right("", 2 * kCellWidth) + "  ";
        continue;
      }
      out_ += Right(Digits(row->paper), kCellWidth) + Right(Digits(row->ours), kCellWidth) +
              (row->erratum.empty() ? "  " : "* ");
    }
    while (out_.back() == ' ') {
      out_.pop_back();
    }
    out_ += '\n';
  }

  void Notes() {
    for (const core::TableRow& row : table_.rows) {
      if (!row.erratum.empty()) {
        out_ += "  * " + FaultText(row.fault) + ", " + row.name + ": " + row.erratum + '\n';
      }
    }
    constexpr double kPercent = 100.0;
    if (table_.mean_relative_error > 0.0) {
      out_ += "  mean relative error " + Digits(kPercent * table_.mean_relative_error) + " %\n";
    }
    if (table_.mean_difference > 0.0) {
      out_ += "  mean difference " + Digits(table_.mean_difference) + " points\n";
    }
    out_ += '\n';
  }

  const core::PaperTable& table_;
  std::vector<std::string> names_;
  std::string out_;
};

}  // namespace

std::string ToText(const core::Reproduction& reproduction) {
  std::string out;
  for (const core::PaperTable& table : reproduction.tables) {
    out += TableText(table).Run();
  }
  out += "Fit of the identified model behind the fault, percent\n" + Left("", kFaultWidth) +
         Right("paper", kCellWidth) + Right("ours", kCellWidth) + Right("true model", 12) + '\n';
  for (const core::FitRow& fit : reproduction.fits) {
    out += Left("  " + FaultText(fit.fault), kFaultWidth) +
           Right(Digits(fit.paper_percent), kCellWidth) +
           Right(Digits(fit.ours_percent), kCellWidth) + Right(Digits(fit.truth_percent), 12) +
           '\n';
  }
  const core::ReproductionSummary& summary = reproduction.summary;
  constexpr double kPercent = 100.0;
  out += "\nSummary\n  Tables 7, 8 (SIA, hardware): mean relative error " +
         Digits(kPercent * summary.tables_7_8_mean_relative_error) +
         " %\n  Tables 5, 6 (SWA, motor, without J = 1.43e-08): mean relative error " +
         Digits(kPercent * summary.tables_5_6_mean_relative_error) + " %\n  nominal fit: SWA " +
         Digits(summary.nominal_fit_swa_percent) + " %, SIA " +
         Digits(summary.nominal_fit_sia_percent) + " % (paper 98.6 %, 98.59 %)\n  " +
         std::to_string(summary.rows) + " numbers, " + std::to_string(summary.rows_with_erratum) +
         " of them marked *: the paper's own errors, see core/README.md\n";
  return out;
}

}  // namespace faultlab::server

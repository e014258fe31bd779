#include "core/paper/reproduction/reproduction.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/paper/paper_tables.h"
#include "tests/paper_bench.h"

namespace faultlab::core {
namespace {

const Reproduction& Ours() {
  static const Reproduction reproduction = Reproduce({.bench = &paper::Bench()});
  return reproduction;
}

const PaperTable& Table(int table) {
  return Ours().tables.at(static_cast<std::size_t>(table - kPaperTableFirst));
}

TEST(Reproduce, MakesTables3To20InOrderWithEveryNumberOfThePaper) {
  ASSERT_EQ(Ours().tables.size(), 18U);
  int parameters = 0;
  int fits = 0;
  for (int table = 3; table <= 20; ++table) {
    EXPECT_EQ(Table(table).table, table);
    EXPECT_FALSE(Table(table).title.empty());
    EXPECT_FALSE(Table(table).settings.empty());
    for (const TableRow& row : Table(table).rows) {
      EXPECT_EQ(row.table, table);
      parameters += table <= 10;
      fits += table >= 13;
    }
  }
  EXPECT_EQ(parameters, kPaperFaultCount * 6);
  EXPECT_EQ(fits, (kPaperFaultCount + 1) * 5);
  EXPECT_EQ(Table(11).rows.size() + Table(12).rows.size(), kPaperFaultCount * 2U);
}

// The goals for the agreement with the paper.
TEST(Reproduce, SiaTables7And8AreWithin5PercentOnAverage) {
  EXPECT_LE(Ours().summary.tables_7_8_mean_relative_error, 0.05);
}

TEST(Reproduce, SwaTables5And6AreWithin3PercentOnAverage) {
  EXPECT_LE(Ours().summary.tables_5_6_mean_relative_error, 0.03);
}

TEST(Reproduce, NominalFitsAreWithin3TenthsOfAPoint) {
  EXPECT_NEAR(Ours().summary.nominal_fit_swa_percent, 98.6, 0.3);
  EXPECT_NEAR(Ours().summary.nominal_fit_sia_percent, 98.59, 0.3);
}

TEST(Reproduce, OurModelFitsEveryFaultWithin1PointOfTheTrueModel) {
  EXPECT_EQ(Ours().fits.size(), kPaperFaultCount + 1U);
  for (const FitRow& row : Ours().fits) {
    const std::string name =
        row.fault ? std::string(Name(row.fault->component)) + " " + std::to_string(row.fault->value)
                  : "healthy";
    EXPECT_GE(row.ours_percent, row.truth_percent - 1.0) << name;
  }
}

TEST(Reproduce, Equation42OnExactCoefficientsGivesThePrintedTables11And12) {
  for (const int table : {11, 12}) {
    for (const TableRow& row : Table(table).rows) {
      if (row.name == "Eq. 42" && row.erratum.empty()) {
        // Two printed digits.
        EXPECT_NEAR(row.ours / row.paper, 1.0, 0.02)
            << Name(row.fault->component) << " " << row.fault->value;
      }
    }
  }
}

TEST(Reproduce, IdentificationIsBetterThanThePapersMedian) {
  std::vector<double> errors;
  for (const int table : {11, 12}) {
    for (const TableRow& row : Table(table).rows) {
      ASSERT_TRUE(row.truth.has_value());
      if (row.name == "isolation fit" && *row.truth > 1e-7) {  // J = 1.43e-8 has a bound only
        errors.push_back(std::abs(row.ours / *row.truth - 1.0));
      }
    }
  }
  std::nth_element(errors.begin(), errors.begin() + 8, errors.end());
  EXPECT_LT(errors[8], 0.005);
}

TEST(Reproduce, ErrataAreMarkedWhereTheyTouchANumber) {
  int exchanged = 0;
  for (const TableRow& row : Table(7).rows) {
    exchanged += row.erratum.find("exchanged") != std::string::npos;
  }
  EXPECT_EQ(exchanged, 6);  // R9 = 33 and 100 kohm, three numbers each
  for (const TableRow& row : Table(19).rows) {
    EXPECT_EQ(row.erratum.empty(), row.fault->value > 1e-7) << row.name;
  }
  EXPECT_GT(Ours().summary.rows_with_erratum, 15);
  EXPECT_LT(Ours().summary.rows_with_erratum, 40);
}

TEST(Reproduce, SameOptionsGiveTheSameNumbersAndMoreRecordsOthers) {
  const Reproduction first = Reproduce({.bench = &paper::Bench(), .repetitions = 1});
  const Reproduction again = Reproduce({.bench = &paper::Bench(), .repetitions = 1});
  int different = 0;
  for (std::size_t t = 0; t < again.tables.size(); ++t) {
    for (std::size_t r = 0; r < again.tables[t].rows.size(); ++r) {
      EXPECT_EQ(again.tables[t].rows[r].ours, first.tables[t].rows[r].ours);
      different += Ours().tables[t].rows[r].ours != first.tables[t].rows[r].ours;
    }
  }
  EXPECT_GT(different, 100);
}

TEST(PaperTables, HoldTheFaultsOfThePaperAndItsKnownNumbers) {
  EXPECT_EQ(PrintedFaults().front().component, "R1");
  EXPECT_EQ(PrintedFaults().back().component, "B");
  EXPECT_EQ(PrintedFaults()[2].fits.mc_0, -150.2);  // Table 14, R1 = 100 ohm
  ASSERT_EQ(paper::Bench().published.faults.size(), PrintedFaults().size());
  const PublishedFault& fault = paper::Bench().published.faults[13];  // Ra = 74.1 ohm
  EXPECT_EQ(fault.component, "Ra");
  EXPECT_EQ(fault.identified, 64.4);         // Table 12
  EXPECT_EQ(fault.swa[1], -2.227);           // Table 5
  EXPECT_EQ(fault.sia[2], 0.06);             // Table 9
  EXPECT_EQ(PaperNominalFits().sia, 98.59);  // Table 13
}

}  // namespace
}  // namespace faultlab::core

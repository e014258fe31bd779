#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "server/csv/csv_record.h"

namespace faultlab::server {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

core::Result<CsvRecord> Parse(const std::string& text) {
  return ParseCsv(text, "file.csv");
}

std::string ErrorOf(const std::string& text) {
  const core::Result<CsvRecord> record = Parse(text);
  return record ? "accepted" : record.error().message;
}

constexpr char kThreeRows[] =
    "t_s,uc_v,um_v,ia_a,n_rpm\n"
    "0.00,3,1.20026,0.000488281,-0.257368\n"
    "0.01,3,6.6861,0.509827,289.143\n"
    "0.02,2,6.8869,0.308167,456.166\n";

TEST(CsvReader, ReadsEveryChannelOfARecording) {
  const core::Result<CsvRecord> read = Parse(kThreeRows);
  ASSERT_TRUE(read) << read.error().message;
  const CsvRecord& record = read.value();
  ASSERT_EQ(record.samples.size(), 3u);
  EXPECT_THAT(record.channels, ElementsAre("t_s", "uc_v", "um_v", "ia_a", "n_rpm"));
  EXPECT_EQ(record.period_s, 0.01);
  EXPECT_EQ(record.samples[2].index, 2);
  EXPECT_EQ(record.samples[2].t_s, 0.02);
  EXPECT_EQ(record.samples[2].uc_v, 2.0);
  EXPECT_EQ(record.samples[1].um_v, 6.6861);
  EXPECT_EQ(record.samples[1].ia_a, 0.509827);
  EXPECT_EQ(record.samples[0].n_rpm, -0.257368);
  EXPECT_TRUE(std::isnan(record.samples[0].ua_v));
  EXPECT_TRUE(record.notes.empty());
}

TEST(CsvReader, TakesColumnsInAnyOrderAndNotesThoseItDoesNotKnow) {
  const core::Result<CsvRecord> read = Parse("um_v,remark,ua_v,t_s,uc_v\n1,x,2,0,3\n4,,5,0.5,6\n");
  ASSERT_TRUE(read) << read.error().message;
  const core::Sample& last = read.value().samples[1];
  EXPECT_EQ(last.um_v, 4.0);
  EXPECT_EQ(last.ua_v, 5.0);
  EXPECT_EQ(last.t_s, 0.5);
  EXPECT_EQ(last.uc_v, 6.0);
  EXPECT_THAT(read.value().notes, ElementsAre(HasSubstr("column 'remark' is not known")));
}

TEST(CsvReader, AcceptsWindowsLineEndsAByteOrderMarkQuotesBlanksAndComments) {
  const core::Result<CsvRecord> read = Parse(
      "\xEF\xBB\xBF# rig bench-1\r\n\"t_s\", uc_v ,um_v\r\n#half way\r\n"
      " 0 , +2.5,\"7\"\r\n\r\n0.01,2,5");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_THAT(read.value().comments, ElementsAre("rig bench-1", "half way"));
  EXPECT_EQ(read.value().samples[0].uc_v, 2.5);
  EXPECT_EQ(read.value().samples[0].um_v, 7.0);
  EXPECT_EQ(read.value().samples[1].um_v, 5.0);
}

TEST(CsvReader, KeepsALostReadingAsAbsentAndSaysHowMany) {
  const core::Result<CsvRecord> read =
      Parse("t_s,uc_v,um_v,ia_a\n0,2,5,NaN\n0.01,2,,nan\n0.02,3,7,0.5\n");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_TRUE(std::isnan(read.value().samples[1].um_v));
  EXPECT_TRUE(std::isnan(read.value().samples[0].ia_a));
  EXPECT_THAT(read.value().notes,
              ElementsAre("file.csv: column um_v: 1 lost readings, the first in line 3",
                          "file.csv: column ia_a: 2 lost readings, the first in line 2"));
}

TEST(CsvReader, TurnsMissingRowsIntoAJumpOfTheIndex) {
  const core::Result<CsvRecord> read =
      Parse("t_s,uc_v,um_v\n0,2,5\n0.01,2,5\n0.02,2,5\n0.05,2,5\n0.06,2,5\n0.07,3,6\n");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read.value().samples[2].index, 2);
  EXPECT_EQ(read.value().samples[3].index, 5);
  EXPECT_EQ(read.value().samples[5].index, 7);
  EXPECT_EQ(read.value().missing_samples, 2);
  EXPECT_THAT(read.value().notes, ElementsAre("file.csv:5: 2 rows missing before this line"));
}

TEST(CsvReader, FindsThePeriodBehindJitterAndAnOffset) {
  std::string text = "t_s,uc_v,um_v\n";
  for (int k = 0; k < 2000; ++k) {
    const double late = k % 7 == 3 ? 0.003 : 0.0002 * (k % 5);
    text += std::to_string(100.0 + 0.01 * k + late) + ",2,5\n";
  }
  const core::Result<CsvRecord> read = Parse(text);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read.value().period_s, 0.01);
  EXPECT_EQ(read.value().samples.back().index, 1999);
  EXPECT_EQ(read.value().missing_samples, 0);
}

TEST(CsvReader, KeepsAPeriodThatIsNoRoundNumber) {
  std::string text = "t_s,uc_v,um_v\n";
  for (int k = 0; k < 3000; ++k) {
    text += std::to_string(k / 300.0) + ",2,5\n";
  }
  const core::Result<CsvRecord> read = Parse(text);
  ASSERT_TRUE(read) << read.error().message;
  constexpr double kSixDecimalsOverThreeThousandRows = 1e-9;
  EXPECT_NEAR(read.value().period_s, 1.0 / 300.0, kSixDecimalsOverThreeThousandRows);
  EXPECT_EQ(read.value().samples.back().index, 2999);
}

TEST(CsvReader, NamesTheMissingColumn) {
  EXPECT_EQ(ErrorOf("t_s,uc_v,ia_a\n0,2,5\n"),
            "file.csv:1: column um_v: missing from the header 't_s,uc_v,ia_a', expected t_s, uc_v, "
            "um_v (required) and ua_v, ia_a, n_rpm (optional), separated by commas");
  EXPECT_THAT(ErrorOf("t_s;uc_v;um_v\n0;2;5\n"), HasSubstr("separated by ';' or tabs"));
  EXPECT_THAT(ErrorOf("0,2,5\n0.01,2,5\n"), StartsWith("file.csv:1: column t_s: missing"));
  EXPECT_THAT(ErrorOf("t_s,uc_v,um_v,uc_v\n"),
              StartsWith("file.csv:1: column uc_v: appears twice"));
}

TEST(CsvReader, NamesTheLineAndColumnOfAWrongCell) {
  EXPECT_EQ(ErrorOf("t_s,uc_v,um_v\n0,2,5\n0.01,2,five\n"),
            "file.csv:3: column um_v: expected a number, found 'five'");
  EXPECT_EQ(ErrorOf("t_s,uc_v,um_v\n0,2,5\n0.01,2,inf\n"),
            "file.csv:3: column um_v: expected a number, found 'inf'");
  EXPECT_EQ(ErrorOf("t_s,uc_v,um_v\n0,2,5\n0.01,2,1e999\n"),
            "file.csv:3: column um_v: expected a number, found '1e999'");
  EXPECT_EQ(ErrorOf("t_s,uc_v,um_v\n0,2,5\n0.01,NaN,5\n"),
            "file.csv:3: column uc_v: expected a number in every row, found 'NaN'; only measured "
            "channels may miss a reading");
  EXPECT_EQ(ErrorOf("# c\nt_s,uc_v,um_v\n0,2,5\n0,01,2,5\n"),
            "file.csv:4: found 4 cells, expected 3 as in the header (decimal point, comma only "
            "between cells)");
  EXPECT_THAT(ErrorOf("t_s,uc_v,um_v\n0,2\n"), StartsWith("file.csv:2: found 2 cells, expected 3"));
  EXPECT_THAT(ErrorOf("t_s,uc_v,um_v\n0,2,\x1b[31m\n"), HasSubstr("found '?[31m'"));
}

TEST(CsvReader, RefusesTimeThatStandsStillOrGoesBack) {
  EXPECT_EQ(ErrorOf("t_s,uc_v,um_v\n0,2,5\n0.01,2,5\n0.01,2,5\n"),
            "file.csv:4: column t_s: time repeats 0.01 s, expected it to rise by one period in "
            "each row");
  EXPECT_EQ(ErrorOf("t_s,uc_v,um_v\n0,2,5\n0.02,2,5\n0.01,2,5\n"),
            "file.csv:4: column t_s: time goes back from 0.02 s to 0.01 s, expected it to rise by "
            "one period in each row");
}

TEST(CsvReader, RefusesTwoTimeBasesAndNamesWhereTheSecondBegins) {
  for (const double second : {0.005, 0.02, 0.015}) {
    std::string text = "t_s,uc_v,um_v\n";
    for (int k = 0; k < 300; ++k) {
      const double t = k < 200 ? 0.01 * k : 0.01 * 199 + second * (k - 199);
      text += std::to_string(t) + ",2,5\n";
    }
    EXPECT_THAT(ErrorOf(text), StartsWith("file.csv:202: column t_s: two time bases: the step is"))
        << second;
  }
}

TEST(CsvReader, RefusesARowThatIsOnNoTick) {
  EXPECT_EQ(ErrorOf("t_s,uc_v,um_v\n0,2,5\n0.01,2,5\n0.02,2,5\n0.035,2,5\n0.04,2,5\n"),
            "file.csv:5: column t_s: step of 0.015 s, expected 0.01 s or a whole multiple where "
            "rows are missing");
  EXPECT_THAT(ErrorOf("t_s,uc_v,um_v\n0,2,5\n0.01,2,5\n0.02,2,5\n1000,2,5\n"),
              HasSubstr("more rows missing than present"));
}

TEST(CsvReader, RefusesWhatIsNoRecordingAtAll) {
  EXPECT_THAT(ErrorOf(""), StartsWith("file.csv:1: the file is empty"));
  EXPECT_THAT(ErrorOf("# only words\n"), StartsWith("file.csv:1: the file is empty"));
  EXPECT_THAT(ErrorOf("t_s,uc_v,um_v\n"), HasSubstr("0 data rows, expected at least 2"));
  EXPECT_THAT(ErrorOf("t_s,uc_v,um_v\n0,1,2\n"), HasSubstr("1 data rows, expected at least 2"));
  EXPECT_THAT(ErrorOf("\xFF\xFEt"), HasSubstr("UTF-16"));
  EXPECT_THAT(ErrorOf("t_s,uc_v,um_v\n0,2,\n0.01,2,nan\n"),
              StartsWith("file.csv:2: column um_v: no row has a number"));
}

TEST(CsvReader, HoldsItsLimits) {
  CsvLimits limits;
  limits.rows_max = 2;
  core::Result<CsvRecord> read = ParseCsv(kThreeRows, "file.csv", limits);
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().code, core::ErrorCode::kTooLarge);
  limits = {};
  limits.bytes_max = 20;
  read = ParseCsv(kThreeRows, "file.csv", limits);
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().code, core::ErrorCode::kTooLarge);
}

}  // namespace
}  // namespace faultlab::server

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

#include "core/signals/random.h"
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
  const core::Result<CsvRecord> read = Parse("um_v,remark,ua_v,t_s,uc_v\n1,x,2,0,3\n4,,5,0.05,6\n");
  ASSERT_TRUE(read) << read.error().message;
  const core::Sample& last = read.value().samples[1];
  EXPECT_EQ(last.um_v, 4.0);
  EXPECT_EQ(last.ua_v, 5.0);
  EXPECT_EQ(last.t_s, 0.05);
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

/// Checks that two rows of a bench, written in another way, are read as the same numbers.
void ExpectTheTwoRows(const std::string& text) {
  const core::Result<CsvRecord> read = Parse(text);
  ASSERT_TRUE(read) << read.error().message << "\n" << text;
  ASSERT_EQ(read.value().samples.size(), 2u) << text;
  const core::Sample& second = read.value().samples[1];
  EXPECT_DOUBLE_EQ(second.t_s, 0.02) << text;
  EXPECT_DOUBLE_EQ(second.uc_v, 2.5) << text;
  EXPECT_DOUBLE_EQ(second.um_v, 4.75) << text;
  EXPECT_DOUBLE_EQ(second.ia_a, 0.125) << text;
  EXPECT_NEAR(second.n_rpm, 1500.0, 1e-3) << text;
  EXPECT_DOUBLE_EQ(read.value().period_s, 0.02) << text;
}

TEST(CsvReader, ReadsTheHeadersAndUnitsThatPeopleWrite) {
  ExpectTheTwoRows("t_s,uc_v,um_v,ia_a,n_rpm\n0,2,4,0,0\n0.02,2.5,4.75,0.125,1500\n");
  ExpectTheTwoRows("Time [s],Uc [V],Um [V],Ia [A],n [rpm]\n0,2,4,0,0\n0.02,2.5,4.75,0.125,1500\n");
  ExpectTheTwoRows("speed_rpm,um(V),uc(V),current(mA),t(ms)\n0,4,2,0,0\n1500,4.75,2.5,125,20\n");
  ExpectTheTwoRows("t/ms,Uc/mV,Um/mV,Ia/mA,n/min-1\n0,2,4,0,0\n20,2500,4750,125,1500\n");
  ExpectTheTwoRows("TIME MS,UC,UM,I,SPEED\r\n0,2,4,0,0\r\n20,2.5,4.75,0.125,1500\r\n");
  ExpectTheTwoRows("t_us,u_c,u_m,i_a,n (rad/s)\n0,2,4,0,0\n20000,2.5,4.75,0.125,157.0796327\n");
  ExpectTheTwoRows(
      "\"t [\xC2\xB5s]\",\"Uc\",\"Um\",\"Ia\",\"n\"\n0,2,4,0,0\n20000,2.5,4.75,.125,1500\n");
}

TEST(CsvReader, ReadsSemicolonsTabsBlanksAndDecimalCommas) {
  ExpectTheTwoRows("\xEF\xBB\xBFt;Uc;Um;Ia;n\r\n0;2;4;0;0\r\n0,02;2,5;4,75;0,125;1500\r\n");
  ExpectTheTwoRows("t\tUc\tUm\tIa\tn\n0\t2\t4\t0\t0\n0,02\t2,5\t4.75\t0,125\t1500\n");
  ExpectTheTwoRows("  t  uc   um ia n\n0 2 4 0 0\n  0.02  2.5 4.75   0.125 1500\n");
  ExpectTheTwoRows("t;Uc;Um;Ia;n\nms;V;mV;mA;rpm\n0;2;4;0;0\n20;2,5;4750;125;1500\n");
  ExpectTheTwoRows("t,Uc,Um,Ia,n\n[s],[V],[V],[A],[rpm]\n0,2,4,0,0\n0.02,2.5,4.75,.125,1500\n");
}

TEST(CsvReader, SaysHowItUnderstoodANameThatIsNotThePlainOne) {
  const core::Result<CsvRecord> read = Parse("time,Uc [V],um_v,temp\n0,2,5,20\n0.01,2,5,20\n");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_THAT(read.value().notes,
              ElementsAre("file.csv: column 'time' was read as t_s",
                          "file.csv: column 'Uc [V]' was read as uc_v",
                          "file.csv: column 'temp' is not known and was ignored"));
}

TEST(CsvReader, SaysWhatToChangeInAHandWrittenFile) {
  EXPECT_EQ(ErrorOf("t [s],Uc [V],Um [bar]\n0,2,5\n"),
            "file.csv:1: column Um [bar]: unit 'bar' is not known for um_v; expected V or mV");
  EXPECT_EQ(ErrorOf("t,Uc,Um\n0,2,5\n10,2,5\n20,2,5\n"),
            "file.csv:3: column t_s: the rows are 10 s apart, too far for a motor that settles in "
            "0.1 s; if the time is in milliseconds, name the column t_ms");
  EXPECT_EQ(ErrorOf("t;Uc;Um\n0;2;5\n0,01;2;1.234,5\n"),
            "file.csv:3: column um_v: expected a number, found '1.234,5'");
  EXPECT_EQ(ErrorOf("t,Uc,Um\n12:61:01,2,5\n"),
            "file.csv:2: column t_s: expected a number, found '12:61:01'; write seconds, or "
            "hh:mm:ss.fff, with a date as yyyy-mm-dd before it");
  EXPECT_EQ(ErrorOf("t,Uc,Um,um\n"),
            "file.csv:1: column um_v: appears twice in the header: 'Um' and 'um'; expected once");
  EXPECT_THAT(ErrorOf("t,Uc,Um\n0,2,5,7\n"), StartsWith("file.csv:2: found 4 cells, expected 3"));
}

TEST(CsvReader, FindsTheNamesBelowTitlesInCommentsAndAfterAStatedSeparator) {
  const std::string rows = "0,2,4,0,0\n0.02,2.5,4.75,0.125,1500\n";
  ExpectTheTwoRows("Bench 7, morning run\nOperator: N. N.\n\nt,Uc,Um,Ia,n\n" + rows);
  ExpectTheTwoRows("Time,Set,Terminal,Amps,Turns\nms,V,V,A,rpm\nt_s,uc_v,um_v,ia_a,n_rpm\n" + rows);
  ExpectTheTwoRows(
      "Time;Motor set voltage;Motor voltage;Motor current;Speed;\nms;V;V;A;rad/s;\n"
      "t_s;uc_v;um_v;ia_a;n_rpm;\n0;2;4;0;0;\n0,02;2,5;4,75;0,125;1500;\n");
  ExpectTheTwoRows("# of bench 7\n# t,Uc,Um,Ia,n\n" + rows);
  ExpectTheTwoRows("sep=;\nt;Uc;Um;Ia;n\n0;2;4;0;0\n0,02;2,5;4,75;0,125;1500\n");
  ExpectTheTwoRows("SEP=,\nt,Uc,Um,Ia,n\n" + rows);
  const auto read = Parse("Bench 7\nOperator: N. N.\nt,Uc,Um\n0,2,4\n0.01,2,4\n");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read.value().notes.front(),
            "file.csv: 2 lines above the names of the columns left out");
}

TEST(CsvReader, KeepsSeparatorsWithinQuotes) {
  ExpectTheTwoRows(
      "\"t\";\"Uc\";\"Um\";\"Ia\";\"n\";\"note; of whom\"\n"
      "\"0\";\"2\";\"4\";\"0\";\"0\";\"cold; \"\"very\"\"\"\n"
      "\"0,02\";\"2,5\";\"4,75\";\"0,125\";\"1500\";\"\"\n");
  EXPECT_EQ(ErrorOf("\"t, Uc, Um\"\n\"0, 2, 4\"\n"),
            "file.csv:1: each line is one cell in quotes: take the quotes at its ends away");
}

TEST(CsvReader, ReadsFilesOfLabViewAndNamesThoseThatItCannot) {
  ExpectTheTwoRows(
      "LabVIEW Measurement\t\nWriter_Version\t2\nDecimal_Separator\t,\n***End_of_Header***\t\n\t\n"
      "Channels\t4\t\nDelta_X\t0,020000\t\n***End_of_Header***\t\t\t\t\t\n"
      "X_Value\tuc (V)\tum (V)\tia (A)\tn (rpm)\tComment\n"
      "0,000000\t2\t4\t0\t0\n0,020000\t2,5\t4,75\t0,125\t1500\n");
  EXPECT_THAT(ErrorOf("LabVIEW Measurement\t\nX_Value\tVoltage_0\n0,0\t2\n"),
              HasSubstr("this is a LabVIEW measurement file"));
  EXPECT_THAT(ErrorOf("Record Length,1.0e+01,,  -0.002,   0.020,\nSample Interval,1e-3,,0,0,\n"),
              HasSubstr("looks like an oscilloscope's export"));
  EXPECT_THAT(ErrorOf("{\"t\": 1}\n"), HasSubstr("this is JSON"));
}

TEST(CsvReader, ReadsTimesOfDayFromTheFirstRowOn) {
  const auto expect_read = [](const std::string& text) {
    const auto read = Parse(text);
    ASSERT_TRUE(read) << read.error().message << "\n" << text;
    EXPECT_EQ(read.value().samples[0].t_s, 0.0) << text;
    EXPECT_NEAR(read.value().samples[2].t_s, 0.04, 1e-6) << text;
    EXPECT_NEAR(read.value().period_s, 0.02, 1e-6) << text;
  };
  expect_read("t,Uc,Um\n09:59:59.98,2,4\n10:00:00,3,6\n10:00:00.02,3,6\n");
  expect_read(
      "t,Uc,Um\n2026-02-28T23:59:59.98Z,2,4\n2026-03-01T00:00:00Z,3,6\n"
      "2026-03-01T00:00:00.02Z,3,6\n");
  expect_read(
      "t;Uc;Um\n2026-02-28 23:59:59,98;2;4\n2026-03-01 00:00:00;3;6\n"
      "2026-03-01 00:00:00,02;3;6\n");
  EXPECT_THAT(ErrorOf("t,Uc,Um\n2026-02-30T00:00:00,2,4\n"), HasSubstr("expected a number"));
}

TEST(CsvReader, KnowsTheUsualUnitsOfSpeedAndNamesInOtherLanguages) {
  const auto speed = [](const std::string& name) {
    const auto read = Parse("t_s,uc_v,um_v," + name + "\n0,2,4,60\n0.01,2,4,60\n");
    EXPECT_TRUE(read) << name << ": " << (read ? "" : read.error().message);
    return read ? read.value().samples[0].n_rpm : 0.0;
  };
  constexpr double kOfRadians = 60.0 * 30.0 / std::numbers::pi;
  for (const char* radians : {"n_rad/s", "n (rad_s)", "n [rad.s-1]", "speed_rad_s", "n/rad s^-1"})
    EXPECT_NEAR(speed(radians), kOfRadians, 1e-9) << radians;
  for (const char* turns : {"n_rpm", "n [U/min]", "vitesse (tr/min)", "n (min^-1)", "n/1/min"})
    EXPECT_EQ(speed(turns), 60.0) << turns;
  EXPECT_NEAR(speed("n_deg/s"), 10.0, 1e-9);
  EXPECT_EQ(speed("n [Hz]"), 3600.0);
  const auto german = Parse(
      "Zeit;Sollspannung;Motorspannung;Strom;Geschwindigkeit\n0;2;4,5;0,2;310\n0,01;3;6;0,3;320\n");
  ASSERT_TRUE(german) << german.error().message;
  EXPECT_EQ(german.value().samples[0].um_v, 4.5);
  EXPECT_EQ(german.value().samples[1].n_rpm, 320.0);
}

TEST(CsvReader, ARefusalSaysWhatEachColumnWasTakenFor) {
  EXPECT_THAT(ErrorOf("Time_sec,Volume_l,Speed_rad_s\n0,3,0\n"),
              HasSubstr("missing: 'Time_sec' was taken for t_s, 'Volume_l' was taken for nothing, "
                        "'Speed_rad_s' was taken for n_rpm; expected t_s, uc_v"));
  EXPECT_THAT(ErrorOf("t,PWM,SPEED\n0,255,0\n"),
              HasSubstr("a duty cycle needs the supply: write uc_v = duty x supply"));
  EXPECT_THAT(ErrorOf("t,u,y\n0,0.4,171.4\n0.02,0.4,171.4\n"),
              HasSubstr("'y' was taken for nothing"))
      << "a speed is no voltage";
}

TEST(CsvReader, TakesLostReadingsAsProgramsWriteThemAndEmptyTails) {
  const auto read = Parse("t_s,uc_v,um_v,ia_a,\n0,2,4,NA,,\n0.01,2,null,0.1,\n0.02,2,4,-,\n");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_TRUE(std::isnan(read.value().samples[0].ia_a));
  EXPECT_TRUE(std::isnan(read.value().samples[1].um_v));
  EXPECT_TRUE(std::isnan(read.value().samples[2].ia_a));
}

TEST(CsvReader, TakesCurrentInPlaceOfVoltage) {
  for (const char* text :
       {"t_s,uc_v,ia_a\n0,2,0.5\n0.01,2,0.5\n", "t_s,uc_v,um_v,ia_a\n0,2,,0.5\n0.01,2,,0.5\n"}) {
    const core::Result<CsvRecord> record = ParseCsv(text, "file.csv");
    ASSERT_TRUE(record.ok()) << record.error().message;
    EXPECT_TRUE(std::isnan(record.value().samples.at(0).um_v));
    EXPECT_EQ(record.value().samples.at(1).ia_a, 0.5);
  }
  EXPECT_EQ(ErrorOf("t_s,uc_v,um_v,ia_a\n0,2,,\n0.01,2,,\n"),
            "file.csv:2: column um_v: no row has a number, expected what was measured");
  EXPECT_EQ(ErrorOf("t_s,uc_v,n_rpm\n0,2,\n0.01,2,nan\n"),
            "file.csv:2: column n_rpm: no row has a number, expected what was measured");
}

TEST(CsvReader, AnAngularVelocityIsInRadiansUnlessItsUnitSaysOtherwise) {
  const auto speed = [](const std::string& header) {
    const auto record = Parse(header + "\n0;3;10\n0.01;4;10\n");
    EXPECT_TRUE(record) << header << ": " << record.error().message;
    return record ? record.value().samples[0].n_rpm : 0.0;
  };
  const double rpm = 300.0 / std::numbers::pi;
  EXPECT_DOUBLE_EQ(speed("t;u;omega"), rpm);
  EXPECT_DOUBLE_EQ(speed("t;u;Angular_Velocity [rad/s]"), rpm);
  EXPECT_DOUBLE_EQ(speed("t;u;omega_rad_s"), rpm);
  EXPECT_DOUBLE_EQ(speed("t;u;omega\ns;V;rad/s"), rpm);
  EXPECT_DOUBLE_EQ(speed("t;u;omega (rpm)"), 10.0);
  EXPECT_DOUBLE_EQ(speed("t;u;omega\ns;V;rpm"), 10.0);
  EXPECT_DOUBLE_EQ(speed("Timestamp(ms);u;Motor_Speed(RPM)"), 10.0);
}

TEST(CsvReader, VoltageAndSpeedAloneAreACommandAndItsAnswer) {
  for (const char* voltage : {"Voltage_V", "Spannung [V]", "napon", "Tension (mV)", "volts"}) {
    const auto record =
        Parse(std::string("Time_sec;") + voltage + ";Speed_rad_s\n0;3;1\n0.01;4;2\n");
    ASSERT_TRUE(record) << voltage << ": " << record.error().message;
    const double milli =
        std::string_view(voltage).find("mV") == std::string_view::npos ? 1.0 : 1e-3;
    EXPECT_DOUBLE_EQ(record.value().samples[1].uc_v, 4.0 * milli) << voltage;
    EXPECT_EQ(record.value().channels, (std::vector<std::string>{"t_s", "uc_v", "n_rpm"}));
    EXPECT_THAT(
        record.value().notes,
        testing::Contains(HasSubstr(std::string("column '") + voltage + "' was read as uc_v")));
  }
  const auto known = Parse("t_s,uc_v,um_v,voltage\n0,2,5,1\n0.01,2,5,1\n");
  ASSERT_TRUE(known) << known.error().message;
  EXPECT_THAT(known.value().notes,
              testing::Contains(HasSubstr("could be uc_v or um_v and was ignored")));
  EXPECT_THAT(ErrorOf("t,voltage,volts,n\n0,1,1,1\n"), HasSubstr("column uc_v: missing"));
  EXPECT_THAT(ErrorOf("t,voltage [lb],n\n0,1,1\n"), HasSubstr("unit 'lb' is not known for uc_v"));
}

/// Rows `period_s` apart, written with two decimals, but for those that `lost` leaves out.
std::string RowsApart(double period_s, auto lost) {
  std::string text = "t_s,uc_v,um_v\n";
  for (int row = 0; row < 400; ++row) {
    if (lost(row)) continue;
    std::array<char, 40> line{};
    std::snprintf(line.data(), line.size(), "%.2f,2,5\n", period_s * row);
    text += line.data();
  }
  return text;
}

TEST(CsvReader, LostRowsDoNotComeAtABeat) {
  const auto none = [](int) { return false; };
  for (const double period_s : {0.0125, 0.015, 0.011, 0.0105}) {
    EXPECT_THAT(ErrorOf(RowsApart(period_s, none)), HasSubstr("lost rows do not come at a beat"))
        << period_s;
  }
  EXPECT_THAT(ErrorOf(RowsApart(0.0125, none)), HasSubstr("rows of even spacing are 0.0125"));
  core::Random random(7);
  const auto by_chance = [&](int) { return random.Uniform(0.0, 1.0) < 0.25; };
  EXPECT_TRUE(Parse(RowsApart(0.01, by_chance))) << "rows that were lost by chance";
  const auto now_and_then = [](int row) { return row % 50 == 49; };
  EXPECT_TRUE(Parse(RowsApart(0.01, now_and_then))) << "a logger that writes its file meanwhile";
}

TEST(CsvReader, NamesTheMissingColumn) {
  EXPECT_EQ(ErrorOf("t_s,uc_v,ua_v\n0,2,5\n"),
            "file.csv:1: column um_v: missing: 't_s' was taken for t_s, 'uc_v' was taken for uc_v, "
            "'ua_v' "
            "was taken for ua_v; expected t_s, uc_v, um_v (or ia_a, or n_rpm, where a bench is "
            "diagnosed by "
            "it) and any of ua_v, ia_a, n_rpm, separated by "
            "commas");
  EXPECT_EQ(ErrorOf("0,2,5\n0.01,2,5\n"),
            "file.csv:1: no header: the first line is '0,2,5'; put a line with the columns' names "
            "above it, for example t_s,uc_v,um_v");
  EXPECT_THAT(ErrorOf("Bench 3, Monday\n0,2,5\n"),
              StartsWith("file.csv:1: column t_s: missing: 'Bench 3' was taken for nothing"));
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

TEST(CsvReader, SaysOfUnevenRowsThatTheirStepsAddUpToAnotherTime) {
  std::string text = "t_s,uc_v,um_v\n";
  double t = 0.0;
  for (int k = 0; k < 40; ++k) {
    text += std::to_string(t) + ",2,5\n";
    t += k < 20 ? 0.0295 : 0.032;  // each step alone is within what is read
  }
  EXPECT_THAT(
      ErrorOf(text),
      HasSubstr("the steps add up to 0.354 s, at 0.030718 s a row 0.368616 s are expected"));
  EXPECT_THAT(ErrorOf(text), HasSubstr("bring them to one period first"));
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

TEST(CsvReader, CopiesNoEndlessFirstLineOrComment) {
  EXPECT_LT(ErrorOf(std::string(1 << 20, 'x')).size(), 300u);
  EXPECT_THAT(ErrorOf(std::string(1 << 20, '\0')), StartsWith("file.csv:1: this is no text"));
  const auto read = Parse("#" + std::string(1 << 20, 'x') + "\n# short\n" + kThreeRows);
  ASSERT_TRUE(read);
  EXPECT_EQ(read.value().comments, std::vector<std::string>{"short"});
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

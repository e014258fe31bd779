// Kinds of files that people bring: times, formats, encodings and tails.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "core/types/number_text.h"
#include "core/types/utf8.h"
#include "server/csv/csv_record.h"

namespace faultlab::server {
namespace {

using ::testing::Contains;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::Truly;
using namespace std::literals;

core::Result<CsvRecord> ReadBytes(std::string_view text) {
  return ParseCsv(text, "file.csv");
}
std::string RefusalOf(std::string_view text) {
  const auto record = ReadBytes(text);
  return record ? "accepted" : record.error().message;
}

/// Three rows 20 ms apart, however their time is written.
void ExpectTwentyMilliseconds(const std::string& text) {
  const auto read = ReadBytes(text);
  ASSERT_TRUE(read) << text << read.error().message;
  ASSERT_EQ(read.value().samples.size(), 3u) << text;
  const double first_s = read.value().samples[0].t_s;
  EXPECT_NEAR(read.value().samples[1].t_s - first_s, 0.02, 1e-6) << text;
  EXPECT_NEAR(read.value().samples[2].t_s - first_s, 0.04, 1e-6) << text;
  EXPECT_EQ(read.value().samples[2].n_rpm, 9.0) << text;
}

/// The number of the second row's channel.
double Second(const std::string& text, double core::Sample::*channel) {
  const auto read = ReadBytes(text);
  EXPECT_TRUE(read) << text << (read ? "" : read.error().message);
  return read ? read.value().samples[1].*channel : -1.0;
}

TEST(CsvKinds, TimesAreReadAsPeopleAndProgramsWriteThem) {
  const std::vector<std::pair<std::string, std::string>> days = {{"", ""},
                                                                 {"2026-05-22 ", ""},
                                                                 {"2026-05-22T", "Z"},
                                                                 {"2026-05-22T", "+02:00"},
                                                                 {"2026-05-22 ", "-0330"},
                                                                 {"2026-05-22 ", "+00:00"},
                                                                 {"22.05.2026 ", ""},
                                                                 {"5/22/2026 ", ""},
                                                                 {"22/05/2026 ", ""},
                                                                 {"2026/05/22 ", " UTC"},
                                                                 {"", " -> "},
                                                                 {"", " ->"}};
  for (const auto& [day, zone] : days) {
    for (const std::string& fraction : {"000"s, "000000"s}) {
      std::string text = "time;u;n\n";
      for (int row = 0; row < 3; ++row) {
        std::string tail = fraction;
        tail[1] = static_cast<char>('0' + 2 * row);
        text += day + "14:05:00." + tail + zone + ";2;" + std::to_string(7 + row) + "\n";
      }
      ExpectTwentyMilliseconds(text);
    }
  }
  ExpectTwentyMilliseconds("t;u;n\n23:59:59.98;2;7\n00:00:00.00;2;8\n00:00:00.02;2;9\n");
  ExpectTwentyMilliseconds(
      "timestamp_ns,u,n\n1779458700000000000,2,7\n1779458700020000000,2,8\n"
      "1779458700040000000,2,9\n");
  ExpectTwentyMilliseconds("t [min],u,n\n0,2,7\n0.000333333333,2,8\n0.000666666667,2,9\n");
  ExpectTwentyMilliseconds("sec,nanosec,u,n\n9,990000000,2,7\n10,10000000,2,8\n10,30000000,2,9\n");
  ExpectTwentyMilliseconds("u,usec,seconds,n\n2,990000,9,7\n2,10000,10,8\n2,30000,10,9\n");
  ExpectTwentyMilliseconds("millis,u,n\n100,2,7\n120,2,8\n140,2,9\n");
  EXPECT_THAT(RefusalOf("t;u;n\n14:05:00;2;7\n13:05:00;2;8\n"), HasSubstr("time goes back"));
  for (const char* wrong : {"31.02.2026 14:05:00",
                            "2026-13-01 14:05:00",
                            "1.2.3 14:05:00",
                            ":",
                            "2026-05-22",
                            "2026-05-22T",
                            "--",
                            "14:05"}) {
    EXPECT_THAT(RefusalOf("t;u;n\n"s + wrong + ";2;7\n"), HasSubstr("expected a number")) << wrong;
  }
}

TEST(CsvKinds, WithoutATimeItIsSaidHowToAddOne) {
  EXPECT_THAT(RefusalOf("# Ts = 0.01 s\nu,n\n2,7\n"),
              HasSubstr("the number of the row x the period ('Ts = 0.01 s' says it)"));
  EXPECT_THAT(RefusalOf("u,n\n2,7\n"), HasSubstr("no column is a time: add one"));
}

TEST(CsvKinds, OtherFormatsAreCalledByTheirNames) {
  const std::vector<std::pair<std::string_view, std::string_view>> formats = {
      {"MATLAB 7.3 MAT-file, Platform"sv, "MAT file of version 7.3"},
      {"MATLAB 5.0 MAT-file"sv, "MAT file"},
      {"\0\0\0\0\x02\0\0\0\x01\0\0\0\0\0\0\0\x02\0\0\0t\0"sv, "level 4"},
      {"\x89HDF\r\n\x1a\n"sv, "HDF5"},
      {"\x93NUMPY\x01\0v\0{'descr'"sv, "NumPy"},
      {"TDSm\x0e\0\0\0"sv, "TDMS"},
      {"PAR1\x15\x04"sv, "Parquet"},
      {"\x80\x04\x95"sv, "pickle"},
      {"PK\x03\x04"sv, "workbook or an archive"},
      {"\xD0\xCF\x11\xE0\xA1"sv, "older Excel"},
      {"SQLite format 3\0"sv, "SQLite"},
      {"%PDF-1.7"sv, "PDF"},
      {"<!DOCTYPE html>\n<table>"sv, "web page"},
      {"<?xml version=\"1.0\"?>"sv, "XML"},
      {"t,u\0,n\n"sv, "no text"},
      {"[1,2,3]"sv, "this is JSON"},
      {"t:0.00,u:2,n:7\nt:0.02,u:2,n:8\n"sv, "each cell has its name in it"}};
  for (const auto& [bytes, name] : formats) {
    const auto read = ReadBytes(bytes);
    ASSERT_FALSE(read) << name;
    EXPECT_THAT(read.error().message, HasSubstr(std::string(name)));
    EXPECT_EQ(read.error().reason, "csv_other_format") << name;
    EXPECT_TRUE(core::IsUtf8(read.error().message)) << name;
  }
}

TEST(CsvKinds, JsonTablesAreRead) {
  ExpectTwentyMilliseconds(
      R"([{"t":0,"u":2,"n":7},{"t":0.02,"u":2,"n":8,"more":1},{"n":9,"t":0.04,"u":2}])");
  ExpectTwentyMilliseconds(R"( {"t":[0,0.02,0.04],"u":[2,2,2],"n":[7,8,9]})");
  EXPECT_THAT(RefusalOf(R"([{"t":0,"u":"2,5","n":7}])"), HasSubstr("expected a number"));
  EXPECT_THAT(RefusalOf(R"([{"t":0,"u":2,"n":seven}])"), HasSubstr("this is JSON"));
  for (const char* lost :
       {"NaN", "Infinity", "-Infinity", "null", "-nan(ind)", "NAN", "None", "inf", "-Inf"}) {
    const auto read = ReadBytes(
        "[{\"t\":0,\"u\":2,\"n\":7,\"NaN \\\" of\":1},{\"t\":0.02,\"u\":2,\"n\":"s + lost + "}]");
    ASSERT_TRUE(read) << lost << read.error().message;
    EXPECT_TRUE(std::isnan(read.value().samples[1].n_rpm)) << lost;
    EXPECT_THAT(read.value().notes, Contains(HasSubstr("'NaN "))) << lost;
  }
}

TEST(CsvKinds, EveryWordOfTheAnswerIsUtf8) {
  const auto read = ReadBytes(
      "t (\xB5s);u;n;W\xE4rme der Wicklung in der Mitte\n0;2;7;1\n20000;2;8;1\n40000;2;9;1\n");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_DOUBLE_EQ(read.value().period_s, 0.02);
  EXPECT_THAT(read.value().notes, Contains(HasSubstr("read as Windows-1252")));
  EXPECT_THAT(read.value().notes, Contains(HasSubstr("'W\xC3\xA4rme der")));
  const auto cyrillic = ReadBytes("t;u;n;Температура обмотки\n0;2;7;1\n0.02;2;8;1\n");
  ASSERT_TRUE(cyrillic);
  for (const auto& each : {read.value().notes, cyrillic.value().notes}) {
    EXPECT_THAT(each, Each(Truly([](const std::string& note) { return core::IsUtf8(note); })));
  }
}

TEST(CsvKinds, TailsAreLeftOutAndSaid) {
  const auto expect_three = [](const std::string& text, const std::string& note) {
    const auto read = ReadBytes(text);
    ASSERT_TRUE(read) << text << read.error().message;
    EXPECT_EQ(read.value().samples.size(), 3u) << text;
    EXPECT_THAT(read.value().notes, Contains(HasSubstr(note))) << text;
  };
  const std::string rows = "t,u,n\n0,2,7\n0.02,2,8\n0.04,2,9\n";
  for (const char* cut : {"0.06", "0.06,", "0.06,2", "0.0"}) {
    expect_three(rows + cut, "has too few cells, and was left out");
  }
  expect_three(rows + ",,\n,,\n", "2 rows without content left out");
  expect_three(rows + " , ,\r\n", "1 row without content left out");
  EXPECT_THAT(RefusalOf(rows + "0.06\n0.08,2,9\n"), HasSubstr("found 1 cells, expected 3"));
  EXPECT_THAT(RefusalOf(rows + "0.06,2,x"), HasSubstr("expected a number"));
  const auto mac = ReadBytes("t,u,n\r0,2,7\r0.02,2,8\r");
  ASSERT_TRUE(mac) << mac.error().message;
  EXPECT_EQ(mac.value().samples.size(), 2u);
}

TEST(CsvKinds, ACellMayHoldALineBreak) {
  ExpectTwentyMilliseconds("t,u,n\n0,2,\"7\n\"\n0.02,2,\"8\r\n\"\n0.04,2,9\n");
  ExpectTwentyMilliseconds(
      "t,u,n,\"note\n of two lines\"\n0,2,7,\n0.02,2,8,\"a\n\nb\"\n0.04,2,9,\n");
  ExpectTwentyMilliseconds("# 5\" motor\n# 6\" more\nt,u,n\n0,2,7\n0.02,2,8\n0.04,2,9\n");
  EXPECT_THAT(RefusalOf("t,u,n,size\n0,2,7,5\"\n0.02,2,8,5\n0.04,2,9,x\n"), HasSubstr("accepted"));
}

TEST(CsvKinds, TablesForPeopleAreRead) {
  ExpectTwentyMilliseconds("|t|u|n|\n|:--|--:|---|\n|0|2|7|\n|0.02|2|8|\n|0.04|2|9|\n");
  ExpectTwentyMilliseconds(" t | u | n\n---+---+---\n 0 | 2 | 7\n 0.02 | 2 | 8\n 0,04 | 2 | 9\n");
  ExpectTwentyMilliseconds("t,u,n\n0 s,2 V,7 rpm\n0.02 sec,2V,8 rpm\n40 ms,2000 mV,9rpm\n");
  ExpectTwentyMilliseconds("t_ms;u;n\n0 ms;2;7\n0,02 s;2;8\n40;2;9\n");
  for (const char* format : {"hh:mm:ss.fff",
                             "HH:mm:ss.000",
                             "hh:mm:ss.zzz",
                             "h:min:s",
                             "UTC: HH:mm:ss",
                             "hh:mm:ss tt"}) {
    ExpectTwentyMilliseconds("Time ("s + format +
                             ");u;n\n14:05:00.000;2;7\n14:05:00.020;2;8\n14:05:00.040;2;9\n");
  }
  ExpectTwentyMilliseconds(
      "| t, s | voltage, V | speed, rpm |\n|--|--|--|\n|0|2|7|\n|0.02|2|8|\n|0.04|2|9|\n");
  ExpectTwentyMilliseconds("t,u,n\n0,2,7 [rpm]\n0.02,2,8min-1\n0.04,2,9 [1/min]\n");
  EXPECT_TRUE(
      std::isnan(Second("t,u,n\n0,2,7 rpm\n0.02,2,--- rpm\n0.04,2,9 rpm\n", &core::Sample::n_rpm)));
  for (const char* wrong : {"2 A", "2 furlong", "V", "2 2 V", "2 V 2", "[V]", "2 [V", "- V"}) {
    EXPECT_THAT(RefusalOf("t,u,n\n0,"s + wrong + ",7\n"), HasSubstr("expected a number")) << wrong;
  }
  EXPECT_EQ(RefusalOf("t_s,uc_v,n_rpm,|n|\n0,2,7,7\n0.02,2,8,8\n"), "accepted");
  EXPECT_EQ(RefusalOf("t uc n |n|\n0 2 7 7\n0.02 2 8 8\n"), "accepted");
  ExpectTwentyMilliseconds("Time (s)|Voltage (V)|Speed (rpm)\n0|2|7\n0.02|2|8\n0.04|2|9\n");
  ExpectTwentyMilliseconds("t,u,n\n0,2,7 1/min\n0.02,2,8 min-1\n0.04,2,9 rpm\n");
  EXPECT_THAT(RefusalOf("t;u;n\n0,01;2,00;1.037 rpm\n0,02;2,00;1.038 rpm\n"),
              HasSubstr("is the mark of the second one of thousands?"));
  for (const char* unit : {"n (unit: rad/s)", "n [CH3: rad/s]"}) {
    const auto turns = ReadBytes("t,u,"s + unit + "\n0,2,1\n0.02,2,1\n");
    ASSERT_TRUE(turns) << unit << turns.error().message;
    EXPECT_NEAR(turns.value().samples[0].n_rpm, 9.549, 1e-3) << unit;
  }
  for (const char* unit : {"1:10", "CH1:x10", "%"}) {
    EXPECT_THAT(RefusalOf("t_s,uc_v ("s + unit + "),n\n0,2,7\n0.02,2,7\n"),
                HasSubstr("'"s + unit + "' is not known"));
  }
  const auto asked_for =
      ReadBytes("t,u (V: measured),Voltage (V: setpoint),n\n0,5,2,7\n0.02,5,2,7\n");
  ASSERT_TRUE(asked_for) << asked_for.error().message;
  EXPECT_EQ(asked_for.value().samples[0].uc_v, 2.0) << "more words stand behind the unit";
  std::string many = "t,u,n";
  std::string row = ",2,7";
  for (int i = 0; i < 253; ++i) {
    many += ",x" + std::to_string(i);
    row += ",0";
  }
  EXPECT_EQ(RefusalOf(many + "\n0" + row + "\n0.02" + row + "\n"), "accepted");
  EXPECT_THAT(RefusalOf(many + ",one more\n"), HasSubstr("more than 256 columns"));
}

TEST(CsvKinds, RowsBeforeTheClockBeginsAgainAreLeftOut) {
  std::string text = "t;u;n\n7.31;2;3\n7.33;2;4\n";
  for (int row = 0; row < 30; ++row) text += std::to_string(20 * row) + "e-3;2;9\n";
  const auto read = ReadBytes(text);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read.value().samples.size(), 30u);
  EXPECT_EQ(read.value().samples.front().index, 0);
  EXPECT_THAT(read.value().notes,
              Contains(HasSubstr("the time begins again in line 4: 2 rows before it left out")));
  EXPECT_THAT(RefusalOf(text + "0;2;9\n"), HasSubstr("34: column t_s: time goes back"))
      << "once alone";
  EXPECT_THAT(RefusalOf("t;u;n\n1;2;3\n0;2;3\n0.02;2;3\n"), HasSubstr("time goes back"));
  std::string swapped = "t;u;n\n0;2;9\n0.01;2;9\n0.03;2;9\n0.02;2;9\n";
  std::string by_clock = "t;u;n\n14:00:03;2;9\n14:00:04;2;9\n";
  for (int row = 4; row < 60; ++row) {
    swapped += core::Format("%.2f;2;9\n", 0.01 * row);
    by_clock += core::Format("14:00:00.%03d;2;9\n", 10 * row);
  }
  EXPECT_THAT(RefusalOf(swapped), HasSubstr("5: column t_s: time goes back"))
      << "a row is misplaced";
  std::string at_zero = "t;u;n\n0;2;9\n0.01;2;9\n";
  for (int row = 0; row < 30; ++row) at_zero += core::Format("%.2f;2;9\n", 0.01 * row);
  EXPECT_EQ(RefusalOf(at_zero), "accepted") << "a board that resets begins at the same zero";
  for (const std::string day : {"", "2026-05-22 "}) {
    std::string reset = "t;u;n\n" + day + "18:00:03.00;2;9\n" + day + "18:00:03.01;2;9\n";
    for (int row = 0; row < 30; ++row) reset += day + core::Format("00:00:00.%03d;2;9\n", 10 * row);
    const auto from_midnight = ReadBytes(reset);
    ASSERT_TRUE(from_midnight) << from_midnight.error().message;
    EXPECT_EQ(from_midnight.value().samples.size(), 30u)
        << "a clock that is reset is not at midnight";
  }
  const auto clock = ReadBytes(by_clock);
  ASSERT_TRUE(clock) << clock.error().message;
  EXPECT_EQ(clock.value().samples.front().t_s, 0.0);
  EXPECT_NEAR(clock.value().samples.back().t_s, 0.55, 1e-9);
}

TEST(CsvKinds, RowsOfTheRunBeforeMayStandAboveTheNames) {
  ExpectTwentyMilliseconds("3010,2.00,12.4\n3020,2\ntime_ms,uc,rpm\n0,2,7\n20,2,8\n40,2,9\n");
  ExpectTwentyMilliseconds("1500\nt,uc,n\n0,2,7\n0.02,2,8\n0.04,2,9\n");
  EXPECT_THAT(RefusalOf("0,2,7\n0.02,2,8\ntime,temperature\n"), HasSubstr("no header"));
}

TEST(CsvKinds, AnUnknownUnitOfTheOnlyMeasurementIsNamed) {
  for (const char* unit : {"tr/mn", "devir/dakika", "ticks/s"}) {
    EXPECT_THAT(RefusalOf("t,u,vitesse ("s + unit + ")\n0,2,7\n0.02,2,8\n"),
                HasSubstr("unit '"s + unit + "' is not known for n_rpm"));
  }
}

TEST(CsvKinds, RowsOfNoPeriodAreExplained) {
  std::string text = "t;u;n\n";
  for (int row = 0; row < 40; ++row) {
    text += core::Format("%.4f;2;9\n", 0.02 * row + 0.009 * (row % 3) + (row > 20 ? 0.005 : 0.0));
  }
  EXPECT_THAT(RefusalOf(text), HasSubstr("bring them to one period"));
  EXPECT_THAT(RefusalOf("t,u,n\n0,2,7\n0.02,2,7\n0.04,2,7\n0.06,2,7\n0.08,2,7\n0.11,2,7\n0.13,2,7\n"
                        "0.15,2,7\n0.17,2,7\n0.19,2,7\n0.21,2,7\n0.23,2,7\n0.25,2,7\n"),
              Not(HasSubstr("evenly")));
}

TEST(CsvKinds, ARowOfUnitsIsKnownThoughOneOfThemIsNot) {
  EXPECT_THAT(RefusalOf("t,u,i,n,temp\ns,V,A,rad.s,Deg C\n0,2,1,7,25\n"),
              HasSubstr("unit 'rad.s' is not known; expected rpm"));
  ExpectTwentyMilliseconds("t,u,n,temp\nms,V,rpm,Deg C\n0,2,7,25\n20,2,8,25\n40,2,9,25\n");
}

TEST(CsvKinds, RowsOfTwoSourcesAndAQuotedTitleAreExplained) {
  EXPECT_THAT(RefusalOf("t_s,uc_v,ia_a,n_rpm\n0,2,0.6,\n0.003,,,13\n"),
              HasSubstr("where the rows of two sources alternate"));
  EXPECT_THAT(
      RefusalOf("\"# Test of 3 May, bus = 14.9 V\"\ntime [s],speed set [Hz],speed [Hz]\n0,1,1\n"),
      HasSubstr("column uc_v: missing"));
}

TEST(CsvKinds, TwoTimesAreAddedOnlyWhereTheyAreParts) {
  for (const char* twice : {"ms,sec,u,n\n0,0,2,7\n10,0.01,2,8\n20,0.02,2,9\n",
                            "seconds,micros,u,n\n0,0,2,7\n0.01,10000,2,8\n0.02,20000,2,9\n",
                            "sec,ms,u,n\n0,0,2,7\n1,1000,2,8\n2,2000,2,9\n"}) {
    const auto read = ReadBytes(twice);
    if (!read) {  // at a row a second
      EXPECT_THAT(read.error().message, HasSubstr("too far")) << twice;
      continue;
    }
    EXPECT_DOUBLE_EQ(read.value().period_s, 0.01) << twice;
    EXPECT_THAT(read.value().notes, Contains(HasSubstr("the one in seconds was taken"))) << twice;
  }
  ExpectTwentyMilliseconds(
      "header.stamp.sec,header.stamp.nanosec,u,n\n5,990000000,2,7\n6,10000000,2,8\n6,30000000,2,"
      "9\n");
  ExpectTwentyMilliseconds("secs,nsecs,u,n\n5,990000000,2,7\n6,10000000,2,8\n6,30000000,2,9\n");
}

TEST(CsvKinds, ALetterIsLessThanANameWithItsUnit) {
  EXPECT_EQ(Second("t_ms,u,n,T\n0,2,7,25\n10,2,8,25.1\n", &core::Sample::t_s), 0.01);
  EXPECT_EQ(Second("time_s,u,n,T\n0,2,7,25\n0.01,2,8,25.1\n", &core::Sample::t_s), 0.01);
  EXPECT_EQ(Second("T,u,n\n0,2,7\n0.01,2,8\n", &core::Sample::t_s), 0.01) << "where it is all";
  EXPECT_EQ(Second("n,time_s,u,motor speed (rpm)\n0,0,2,7\n1,0.01,2,8\n", &core::Sample::n_rpm),
            8.0);
  EXPECT_EQ(Second("n,time_s,u,speed\n0,0,2,7\n1,0.01,2,8\n", &core::Sample::n_rpm), 8.0);
  EXPECT_EQ(Second("i,t_s,u,current_mA\n0,0,2,700\n1,0.01,2,800\n", &core::Sample::ia_a), 0.8);
  EXPECT_EQ(
      Second("t,u,motor speed [rpm],U_min,U_max\n0,2,7,1,3\n0.01,2,8,1,3\n", &core::Sample::n_rpm),
      8.0);
  EXPECT_EQ(Second("t,u,Motor current [mA],Ma\n0,2,700,5\n0.01,2,800,5\n", &core::Sample::ia_a),
            0.8);
  EXPECT_EQ(Second("t [ms],Us,uc_v,n\n0,12,2,7\n10,12,2,8\n", &core::Sample::t_s), 0.01);
  EXPECT_EQ(Second("Timestamp,Elapsed (s),u,n\n5,0,2,7\n5,0.01,2,8\n", &core::Sample::t_s), 0.01);
}

TEST(CsvKinds, MarksOfThousandsAreNoDecimalMarks) {
  EXPECT_THAT(RefusalOf("t;u;n\n0,00;2;999\n0,01;2;1.037\n"),
              HasSubstr("is the mark of the second one"));
  EXPECT_THAT(RefusalOf("t\tu\tn\n0.00\t2\t999\n0.01\t2\t1,115\n"),
              HasSubstr("'0.00' and '1,115'"));
  EXPECT_THAT(RefusalOf("t_ms\tu\tn\n0\t2.500\t987\n10\t2.500\t1,096\n"),
              HasSubstr("'2.500' and '1,096'"));
  EXPECT_EQ(Second("t;u;n\n0,00;2,5;999\n0,01;2,5;999,125\n", &core::Sample::n_rpm), 999.125);
  EXPECT_EQ(Second("t;u;n\n0.00;2.5;999\n0.010;2.125;1.125\n", &core::Sample::n_rpm), 1.125);
}

TEST(CsvKinds, AnAngularSpeedCountsRadians) {
  constexpr double kRpm = 9.549296585513721;
  for (const char* name : {"\xCF\x89 [1/s]",
                           "Winkelgeschwindigkeit in s^-1",
                           "w [1/s]",
                           "angular velocity (1/s)",
                           "theta_dot (rad/s)",
                           "omega\ns;V;1/s"}) {
    EXPECT_NEAR(
        Second("t;u;"s + name + "\n0;2;1\n0.01;2;2\n", &core::Sample::n_rpm), 2.0 * kRpm, 1e-9)
        << name;
  }
  EXPECT_EQ(Second("t;u;Drehzahl [1/s]\n0;2;1\n0.01;2;2\n", &core::Sample::n_rpm), 120.0);
  EXPECT_EQ(Second("t;u;Encoder speed (rpm)\n0;2;1\n0.01;2;2\n", &core::Sample::n_rpm), 2.0);
  for (const char* named : {"position [rad/s];n", "theta_dot (rad/s);n", "motor [rpm];rpm"}) {
    EXPECT_EQ(Second("t;u;"s + named + "\n0;2;1;3\n0.01;2;2;4\n", &core::Sample::n_rpm), 4.0)
        << named << ": a name says more than a unit";
  }
}

TEST(CsvKinds, ARowOfUnitsMustAgreeWithTheTitles) {
  EXPECT_THAT(RefusalOf("t_s;uc_v;n_rpm\ns;V;rad/s\n0;2;1\n0.01;2;1\n"),
              HasSubstr("the title names another unit than the row of units, 'rad/s'"));
  EXPECT_THAT(RefusalOf("t [s];u [V];n [rpm]\nms;V;rpm\n0;2;1\n0.01;2;1\n"), HasSubstr("take one"));
  EXPECT_EQ(Second("t [s];u [V];n [rpm]\ns;V;1/min\n0;2;1\n0.01;2;1\n", &core::Sample::n_rpm), 1.0);
}

TEST(CsvKinds, AWrongUnitOfTheTimeIsNamed) {
  const auto apart = [](double step) {
    std::string text = "time,u,n\n";
    for (int k = 0; k < 5; ++k) text += core::Format("%.12g", 45778.5 + step * k) + ",2,7\n";
    return RefusalOf(text);
  };
  EXPECT_THAT(apart(1.0), HasSubstr("in milliseconds, name the column t_ms"));
  EXPECT_THAT(apart(10'000.0), HasSubstr("in microseconds, name the column t_us"));
  EXPECT_THAT(apart(1e7), HasSubstr("in nanoseconds, name the column t_ns"));
  EXPECT_THAT(apart(1.1574074e-7), HasSubstr("multiply it by 86400"));
  EXPECT_NEAR(
      Second("t [ms];u;n\n12:00:00.010;2;7\n12:00:00.020;2;8\n", &core::Sample::t_s), 0.01, 1e-9);
}

TEST(CsvKinds, WhatIsNotUnderstoodIsNotGuessed) {
  for (const char* name : {"\xCF\x83 i", "给定转速n(rpm)", "Vdc", "Vbus", "V_supply"}) {
    const auto read = ReadBytes("t;u;i;n;"s + name + "\n0;2;0.1;7;9\n0.01;2;0.2;8;9\n");
    ASSERT_TRUE(read) << name << read.error().message;
    EXPECT_EQ(read.value().samples[1].n_rpm, 8.0) << name;
    EXPECT_EQ(read.value().samples[1].uc_v, 2.0) << name;
  }
  EXPECT_EQ(Second("time,cmd,current,vel\n0,2,1,7\n0.01,2,1,8\n", &core::Sample::n_rpm), 8.0);
  const auto duty = ReadBytes("t,V_in [V],PWM [%],n\n0,12,50,7\n0.01,12,60,8\n");
  ASSERT_TRUE(duty);
  EXPECT_THAT(duty.value().questions, Contains(HasSubstr("uc_v is the duty x the supply")));
  EXPECT_THAT(RefusalOf("\xE2\xF0\xE5\xEC\xFF;u;n\n0;2;7\n"), HasSubstr("the file is no UTF-8"));
  EXPECT_THAT(RefusalOf("time,Elapsed,u,n\n0,0,2,7\n"), HasSubstr("'time' and 'Elapsed'"));
}

TEST(CsvKinds, TitlesMayBreakAndSayInBeforeTheirUnits) {
  const std::vector<std::string> headers = {"\"Time\n(s)\";\"Voltage\n(V)\";\"Speed\n(rpm)\"",
                                            "t, s;U, V;n, rpm",
                                            "Temps en s;u;vitesse en rpm",
                                            "Czas w s;u;n",
                                            "Vreme u s;Napon u V;n",
                                            "Time,12:00:00\nTime (s);Voltage (V);Speed (rpm)",
                                            "% t_s;uc_v;n_rpm",
                                            "%time;u;n"};
  for (const std::string& header : headers) {
    const auto read = ReadBytes(header + "\n0;2;7\n0.01;2;8\n");
    ASSERT_TRUE(read) << header << ": " << read.error().message;
    EXPECT_EQ(read.value().samples[1].n_rpm, 8.0) << header;
  }
}

TEST(CsvKinds, MoreTimesAreRead) {
  const std::vector<std::pair<std::string, std::string>> pairs = {
      {"11:59:59.980 AM", "12:00:00.000 PM"},
      {"01-May-2026 23:59:59.980", "02-May-2026 00:00:00.000"},
      {"0 days 00:00:00.010", "0 days 00:00:00.030"},
      {"22.05.26 14:05:00.000", "22.05.26 14:05:00.020"},
      {"2026.05.01. 14:05:00.000", "2026.05.01. 14:05:00.020"},
      {"2026-10-25T02:59:59.990+02:00", "2026-10-25T02:00:00.010+01:00"}};
  for (const auto& [first, second] : pairs) {
    EXPECT_NEAR(
        Second("t;u;n\n" + first + ";2;7\n" + second + ";2;8\n", &core::Sample::t_s), 0.02, 1e-6)
        << first;
  }
  EXPECT_THAT(RefusalOf("t;u;n\n12:00:00:010;2;7\n"), HasSubstr("write seconds, or hh:mm:ss.fff"));
}

TEST(CsvKinds, AUnitAfterABlankIsThatUnit) {
  EXPECT_EQ(Second("t s;u V;n rpm\n0;2;7\n0.01;3;8\n", &core::Sample::uc_v), 3.0);
  EXPECT_EQ(Second("t;u;Motor I mA\n0;2;700\n0.01;2;800\n", &core::Sample::ia_a), 0.8);
  EXPECT_EQ(Second("t;u;speed;rpm\n0;2;1;7\n0.01;2;1;8\n", &core::Sample::n_rpm), 8.0);
  EXPECT_THAT(RefusalOf("t;u;encoder [Hz]\n0;2;900\n0.01;2;900\n"), HasSubstr("is a position"));
}

TEST(CsvKinds, AClockMayStandBesideDecimalCommas) {
  EXPECT_EQ(
      Second("t;u;n\n12:00:00.000;2,000;11,705\n12:00:00.010;2,000;12,125\n", &core::Sample::n_rpm),
      12.125);
  for (const std::string tail : {" UTC", " +0200", " PM", ""}) {
    EXPECT_NEAR(Second("t;u;n\n01:00:00.00" + tail + ";2;7\n01:00:00.02" + tail + ";2;8\n",
                       &core::Sample::t_s),
                0.02,
                1e-9)
        << tail;
  }
}

TEST(CsvKinds, AMemberThatTheFirstRowLacksIsAColumn) {
  EXPECT_EQ(Second(R"([{"t":0,"u":2,"i":1},{"t":0.01,"u":2,"i":1,"n":8}])", &core::Sample::n_rpm),
            8.0);
}

}  // namespace
}  // namespace faultlab::server

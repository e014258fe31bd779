// Titles as people of several languages write them: words, qualifiers, spellings and units at
// random.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <vector>

#include "core/signals/random.h"
#include "server/csv/csv_header.h"
#include "server/csv/csv_record.h"

namespace faultlab::server {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

struct Language {
  std::string_view time;
  std::string_view voltage;
  std::string_view current;
  std::string_view speed;
  std::string_view measured;  ///< "measured", or of the motor
};
constexpr Language kLanguages[] = {
    {"time", "voltage", "current", "speed", "measured"},
    {"t", "u", "i", "n", "filt"},
    {"Timestamp", "Volts", "Amps", "RPM", "actual"},
    {"Zeit", "Spannung", "Strom", "Drehzahl", "gemessen"},
    {"temps", "tension", "courant", "vitesse", "mesurée"},
    {"tiempo", "voltaje", "corriente", "velocidad", "medida"},
    {"tempo", "tensão", "corrente", "velocidade", "medido"},
    {"tempo", "tensione", "corrente", "velocità", "misurata"},
    {"czas", "napięcie", "prąd", "prędkość", "zmierzona"},
    {"čas", "napětí", "proud", "rychlost", "merena"},
    {"vreme", "napon", "struja", "brzina", "izmerena"},
    {"време", "напон", "струја", "брзина", "измерена"},
    {"zaman", "gerilim", "akım", "hız", "ölçülen"},
    {"tijd", "spanning", "stroom", "snelheid", "shaft"},
    {"idő", "feszültség", "áram", "fordulatszám", "real"},
    {"timp", "tensiune", "curent", "turație", "avg"},
    {"time", "input voltage", "motor current", "rotational speed", "shaft"},
    {"Zeit", "Spannung", "Ankerstrom", "Drehzahl", "ist"},
    {"temps", "tension", "courant", "vitesse de rotation", "mesurée"},
    {"tempo", "tensione", "corrente", "velocità di rotazione", "misurata"},
    {"czas", "napięcie", "prąd twornika", "prędkość obrotowa", "zmierzona"},
    {"zaman", "giriş gerilimi", "motor akımı", "motor hızı", "ölçülen"}};

class Titles {
 public:
  explicit Titles(std::uint64_t seed) : random_(seed) {}

  std::string Of(std::string_view word, std::string_view qualifier, std::string_view unit) {
    std::string name(word);
    const std::string between = Any({" ", "_"});
    if (Chance())
      name = Chance() ? std::string(qualifier) + between + name
                      : name + between + std::string(qualifier);
    if (Chance()) name = Upper(name);
    if (unit.empty() || Chance()) return name;
    return name + Unit(unit);
  }
  /// The word of a quantity beside one that no title of a recording has.
  std::string Foreign(std::string_view word, std::string_view unit) {
    std::string other = Any({"field",   "limit",  "bus",     "supply", "state", "error", "torque",
                             "winding", "load",   "battery", "Feld",   "Netz",  "Last",  "Fehler",
                             "champ",   "réseau", "carga",   "campo",  "błąd",  "hata"});
    if (Chance()) {
      other = "x";  // no known word has it
      while (other.size() < 6) other += Any({"a", "b", "e", "g", "k", "o", "r", "z"});
    }
    const std::string between = Any({" ", "_", "."});
    std::string name =
        Chance() ? other + between + std::string(word) : std::string(word) + between + other;
    if (Chance()) name = Upper(name);
    return Chance() ? name : name + Unit(unit);
  }
  bool Chance() { return random_.Uniform(0.0, 1.0) < 0.5; }

 private:
  std::string Unit(std::string_view unit) {
    const std::string format = Any({" [%]", "(%)", " (%)", "_%", "/%", " in %", " %"});
    return format.substr(0, format.find('%')) + std::string(unit) +
           format.substr(format.find('%') + 1);
  }
  std::string Any(const std::vector<std::string>& from) {
    return from[static_cast<std::size_t>(random_.Uniform(0.0, 1.0) *
                                         static_cast<double>(from.size()))];
  }
  static std::string Upper(std::string text) {
    for (char& c : text) c = c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
    return text;
  }
  core::Random random_;
};

TEST(CsvNames, AreUnderstoodInManyLanguagesWithQualifiersAndUnits) {
  Titles titles(11);
  for (int round = 0; round < 200; ++round) {
    for (const Language& each : kLanguages) {
      const std::string speed_unit = titles.Chance() ? "rpm" : "1/min";
      const std::string header = titles.Of(each.time, "elapsed", "s") + ";" +
                                 titles.Of(each.voltage, each.measured, "V") + ";" +
                                 titles.Of(each.current, "motor", "A") + ";" +
                                 titles.Of(each.speed, each.measured, speed_unit);
      const auto read = ParseCsv(header + "\n0;2;0.1;50\n0.01;3;0.2;60\n", "file.csv");
      ASSERT_TRUE(read) << header << ": " << read.error().message;
      ASSERT_EQ(read.value().channels, (std::vector<std::string>{"t_s", "uc_v", "ia_a", "n_rpm"}))
          << header;
      EXPECT_EQ(read.value().samples[1].n_rpm, 60.0) << header;
    }
  }
}

TEST(CsvNames, OfSomethingElseRefuseNoFile) {
  const std::vector<std::string> others = {"n_ref",
                                           "speed set [Hz]",
                                           "u_bus",
                                           "supply voltage",
                                           "time_of_day",
                                           "delta_t",
                                           "temperature",
                                           "Torque [Nm]",
                                           "t_motor_C",
                                           "i_limit",
                                           "nm",
                                           "v_ref",
                                           "battery [V]",
                                           "Winkel",
                                           "pos_deg",
                                           "error",
                                           "n [furlong]",
                                           "current_state",
                                           "velocity_goal [rpm]",
                                           "номер",
                                           "温度",
                                           "label",
                                           "ток",
                                           "field.current",
                                           "field.voltage",
                                           "current_rotation",
                                           "rotation_time_us",
                                           "delta_rotation",
                                           "v_rotation",
                                           "Analogeingang [V]",
                                           "Eingangsspannung [V]",
                                           "napięcie wejściowe"};
  for (const std::string& other : others) {
    for (const bool first : {false, true}) {
      const std::string header = first ? other + ";t;u;i;n" : "t;u;i;n;" + other;
      const std::string row =
          first ? "7;0;2;0.1;50\n7;0.01;3;0.2;60\n" : "0;2;0.1;50;7\n0.01;3;0.2;60;7\n";
      const auto read = ParseCsv(header + "\n" + row, "file.csv");
      ASSERT_TRUE(read) << header << ": " << read.error().message;
      EXPECT_EQ(read.value().samples[1].n_rpm, 60.0) << header;
      EXPECT_EQ(read.value().samples[1].uc_v, 3.0) << header;
      EXPECT_THAT(read.value().notes, Contains(HasSubstr("column '"))) << header;
    }
  }
}

TEST(CsvNames, WithAWordOfSomethingElseAreNoChannels) {
  Titles titles(12);
  for (int round = 0; round < 100; ++round) {
    for (const Language& each : kLanguages) {
      for (const std::string& title : {titles.Foreign(each.time, "s"),
                                       titles.Foreign(each.voltage, "V"),
                                       titles.Foreign(each.current, "mA"),
                                       titles.Foreign(each.speed, "rpm")}) {
        EXPECT_EQ(ParseColumnName(title).channel, nullptr) << title;
      }
    }
  }
}

TEST(CsvNames, TheSecondOfAMinuteIsNotTheTime) {
  for (const char* second : {"Sekunde", "second", "saniye"}) {
    const auto read = ParseCsv(
        std::string("Minute;") + second + ";Zeit;u;n\n5;59;0;2;50\n6;0;0.01;3;60\n", "file.csv");
    ASSERT_TRUE(read) << second << ": " << read.error().message;
    EXPECT_EQ(read.value().samples[1].t_s, 0.01) << second;
  }
}

TEST(CsvNames, OfTwoForOneChannelTheNearerIsTaken) {
  const auto read = [](const std::string& header) {
    const auto record =
        ParseCsv(header + "\n0;0;2;5;9\n0.01;10;3;6;9\n0.02;20;3;6;9\n", "file.csv");
    EXPECT_TRUE(record) << header << ": " << record.error().message;
    return record;
  };
  const auto times = read("time_s;time_ms;u;i;n");
  EXPECT_EQ(times.value().samples[1].t_s, 0.01);
  EXPECT_THAT(times.value().notes, Contains(HasSubstr("'time_ms' was left out: 'time_s' is t_s")));
  EXPECT_EQ(read("t;x;u;i;i_filt").value().samples[1].ia_a, 6.0);
  EXPECT_EQ(read("t;x;u;i_filt;i").value().samples[1].ia_a, 9.0);
  EXPECT_EQ(read("t;x;u;n_rpm;n measured").value().samples[1].n_rpm, 6.0);
  EXPECT_EQ(ParseCsv("t;u;i;i\n0;1;2;3\n", "f").error().reason, "csv_column_twice");
}

TEST(CsvNames, WhatTheFileLacksIsAskedAbout) {
  const auto read = ParseCsv("t;u;i;schnell [rpm]\n0;2;0.1;5\n0.01;2;0.1;5\n", "file.csv");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_THAT(read.value().questions, Contains(HasSubstr("'schnell [rpm]' is not known")));
  EXPECT_THAT(read.value().questions, Contains(HasSubstr("is it n_rpm? Then call it so")));
  const auto angle = ParseCsv("t;u;i;theta\n0;2;0.1;5\n0.01;2;0.1;5\n", "file.csv");
  EXPECT_THAT(angle.value().questions, Contains(HasSubstr("its difference over the period")));
  EXPECT_EQ(
      ParseCsv("t;u;i;n;m [rpm]\n0;2;0.1;5;5\n0.01;2;0.1;5;5\n", "f").value().questions.size(), 0u);
}

TEST(CsvNames, AnOutputWithoutANameIsAskedAbout) {
  EXPECT_THAT(ParseCsv("t,r,y,u\n0,1,2,3\n", "f").error().message,
              HasSubstr("is 'r' or 'y' measured? Call a speed n_rpm, n_rad/s or n_deg/s"));
  EXPECT_NEAR(ParseCsv("t,u,n_deg/s\n0,1,6\n0.01,1,6\n", "f").value().samples[0].n_rpm, 1.0, 1e-9);
}

TEST(CsvNames, AUnitOfTurnsSaysWhatIsFedBack) {
  for (const char* name : {"feedback_rpm", "Sensor (rad/s)", "motor [1/min]", "fb_deg_s"}) {
    EXPECT_EQ(ParseColumnName(name).channel->name, "n_rpm") << name;
  }
  for (const char* other :
       {"commanded_rpm", "reference [rpm]", "feedback", "channel a", "angle_deg"}) {
    EXPECT_EQ(ParseColumnName(other).channel, nullptr) << other;
  }
}

TEST(CsvNames, APlainNameIsNearerThanAUnitOrAWord) {
  const auto first = [](const std::string& header, double core::Sample::*channel) {
    const auto read = ParseCsv(header + "\n0;2;5;9\n0.01;3;6;9\n", "file.csv");
    EXPECT_TRUE(read) << header << ": " << read.error().message;
    return read ? read.value().samples[0].*channel : -1.0;
  };
  for (const char* beside : {"motor [rad/s]", "armature [1/min]", "filtered_rpm", "a [rad/s]"}) {
    for (const char* speed : {"n [rpm]", "speed", "rpm", "n", "motor speed [rpm]", "speed_rpm"}) {
      EXPECT_EQ(first(std::string("t;u;") + speed + ";" + beside, &core::Sample::n_rpm), 5.0)
          << speed << " " << beside;
    }
  }
  EXPECT_EQ(first("t;u;i;ma", &core::Sample::ia_a), 5.0) << "a moving average";
  for (const char* voltages : {"u;n;u_fb", "u;n;u now", "voltage;n;voltage feedback"}) {
    EXPECT_EQ(first(std::string("t;") + voltages, &core::Sample::uc_v), 2.0) << voltages;
  }
  EXPECT_EQ(first("t;u;uₘ;n", &core::Sample::uc_v), 2.0);
  EXPECT_EQ(ParseCsv("t;voltage 1;voltage 2;n\n0;2;5;9\n", "f").error().field, "uc_v");
}

TEST(CsvNames, SubscriptsMarksAndUnitsAlone) {
  const auto second = [](const std::string& header, double core::Sample::*channel) {
    const auto read = ParseCsv(header + "\n0;2;100;50\n0.01;3;100;50\n", "file.csv");
    EXPECT_TRUE(read) << header << ": " << read.error().message;
    return read ? read.value().samples[1].*channel : -1.0;
  };
  EXPECT_EQ(second("t;u\u2098;iₐ [mA];n", &core::Sample::ia_a), 0.1);
  EXPECT_EQ(second("t;u;iₐ [mA];vite\u0301sse", &core::Sample::ia_a), 0.1) << "no mark of its own";
  for (const char* milliamperes : {"mA", "ma"}) {
    EXPECT_EQ(second(std::string("t;u;") + milliamperes + ";n", &core::Sample::ia_a), 0.1)
        << milliamperes;
  }
  for (const char* other : {"Ns", "Ms", "Us", "Uₛ", "nₛ", "MA", "MV", "MS"}) {
    EXPECT_EQ(ParseColumnName(other).channel, nullptr) << other;
  }
}

TEST(CsvNames, TheOnlyVoltageIsTheCommand) {
  for (const char* name :
       {"Armature Voltage (V)", "Motor voltage", "u_eff_V", "V", "Input Voltage"}) {
    const auto read = ParseCsv(std::string("t;") + name + ";n\n0;2;5\n0.01;3;5\n", "file.csv");
    ASSERT_TRUE(read) << name << ": " << read.error().message;
    EXPECT_EQ(read.value().samples[1].uc_v, 3.0) << name;
  }
  EXPECT_EQ(ParseCsv("t_s;um_v;n\n0;2;5\n0.01;3;5\n", "f").error().field, "uc_v")
      << "it says whose it is";
}

}  // namespace
}  // namespace faultlab::server

#include "server/csv/csv_columns.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <utility>

#include "server/csv/csv_channels.h"
#include "server/csv/csv_header_line.h"
#include "server/csv/csv_text.h"
#include "server/csv/csv_time_base.h"

namespace faultlab::server {
namespace {

using core::Error;
using core::Result;

class NamesReader {
 public:
  explicit NamesReader(const NamesLine& names) : names_(names) {}

  Result<CsvColumns> Run() {
    std::string_view rest = names_.text;
    bool numbers_alone = true;
    for (bool more = true; more;) {
      const std::string_view name = TakeCell(names_.separator, rest, more);
      numbers_alone =
          numbers_alone && !name.empty() && ParseCell(names_.separator, name).has_value();
      if (columns_.cells.size() == kCsvColumnsMax) {
        return Fail(
            "", "csv_columns_full", "more than " + std::to_string(kCsvColumnsMax) + " columns");
      }
      columns_.cells.push_back(ParseColumnName(name));
      titles_.push_back({std::string(name), {}});
    }
    if (numbers_alone) return NoHeader(names_);
    TakeTwoPartsOfTime();
    for (std::size_t channel = 0; channel < kCsvChannelTable.size(); ++channel) {
      if (std::optional<Error> error = Choose(channel)) return *error;
    }
    TakeVoltage();
    for (std::size_t i = 0; i < kCsvChannelTable.size(); ++i) {
      if (found_[i]) {
        columns_.channels.emplace_back(kCsvChannelTable[i].name);
      } else if (kCsvChannelTable[i].required &&
                 !(i == kUmChannel && HasMeasurement([&](std::size_t at) { return found_[at]; }))) {
        return Missing(i);
      }
    }
    Tell();
    return std::move(columns_);
  }

 private:
  struct Title {
    std::string name;
    std::string left_out;  ///< why, of a column that could have been one of a recording
  };

  Error Fail(std::string_view column, std::string reason, const std::string& message) const {
    return CsvError(names_.file, names_.number, column, std::move(reason), message);
  }

  static std::size_t PlaceOf(const CsvChannel* channel) {
    return static_cast<std::size_t>(channel - kCsvChannelTable.data());
  }

  void LeaveOut(std::size_t cell, std::string why) {
    columns_.cells[cell].channel = nullptr;
    titles_[cell].left_out = std::move(why);
  }

  /// "sec" and "nanosec" are one time.
  void TakeTwoPartsOfTime() {
    std::vector<CsvColumn*> times;
    for (CsvColumn& column : columns_.cells) {
      if (column.channel == &kCsvChannelTable[0]) times.push_back(&column);
    }
    const bool parts = times.size() == 2 && times[0]->unit_alone && times[1]->unit_alone &&
                       (times[0]->factor == 1.0) != (times[1]->factor == 1.0);
    for (CsvColumn* each : times) each->adds = parts;
  }

  /// Of the columns that could be this channel the one whose name is nearest to it.
  std::optional<Error> Choose(std::size_t channel) {
    std::optional<std::size_t> best;
    std::optional<std::size_t> twice;
    for (std::size_t i = 0; i < columns_.cells.size(); ++i) {
      const CsvColumn& column = columns_.cells[i];
      if (column.channel != &kCsvChannelTable[channel] || column.either) continue;
      if (column.adds) {
        found_[channel] = true;
        continue;
      }
      if (!column.unknown_unit.empty()) continue;
      if (!best || column.distance < columns_.cells[*best].distance) {
        best = i;
        twice = std::nullopt;
      } else if (column.distance == columns_.cells[*best].distance) {
        twice = i;
      }
    }
    if (!best) return std::nullopt;
    const std::string_view canonical = kCsvChannelTable[channel].name;
    if (twice) {
      return Fail(canonical,
                  "csv_column_twice",
                  "appears twice in the header: '" + Shown(titles_[*best].name) + "' and '" +
                      Shown(titles_[*twice].name) + "'; expected once");
    }
    found_[channel] = true;
    for (std::size_t i = 0; i < columns_.cells.size(); ++i) {
      const CsvColumn& column = columns_.cells[i];
      if (i == *best || column.channel != &kCsvChannelTable[channel] || column.either) continue;
      LeaveOut(i,
               "was left out: '" + Shown(titles_[*best].name) + "' is " + std::string(canonical));
    }
    return std::nullopt;
  }

  /// The only voltage beside a current or a speed is the command. Of several without a command
  /// nobody knows which it is.
  void TakeVoltage() {
    std::vector<std::size_t> any;
    std::vector<std::size_t> either;
    for (std::size_t i = 0; i < columns_.cells.size(); ++i) {
      const CsvColumn& column = columns_.cells[i];
      if (column.channel == nullptr || !IsVoltage(*column.channel) || column.distance == 0)
        continue;
      if (!column.unknown_unit.empty()) continue;
      any.push_back(i);
      if (column.either) either.push_back(i);
    }
    const bool measured = found_[kCurrentChannel] || found_[kSpeedChannel];
    const bool lacks = !found_[kCommandChannel];
    std::optional<std::size_t> command;
    if (lacks) command = Nearest(either);
    if (lacks && either.empty() && any.size() == 1 && measured) command = any[0];
    for (const std::size_t i : either) {
      if (i != command) LeaveOut(i, "could be uc_v or um_v and was ignored: say which");
    }
    if (!command) return;
    CsvColumn& column = columns_.cells[*command];
    found_[PlaceOf(column.channel)] = false;
    column.channel = &kCsvChannelTable[kCommandChannel];
    column.either = false;
    found_[kCommandChannel] = true;
  }

  /// Whose name is plainer by a word than those of all others; nothing where none is.
  std::optional<std::size_t> Nearest(const std::vector<std::size_t>& cells) const {
    constexpr int kWord = 8;
    const auto distance_of = [this](std::size_t i) { return columns_.cells[i].distance; };
    const auto nearest = std::ranges::min_element(cells, {}, distance_of);
    if (nearest == cells.end()) return std::nullopt;
    const bool alone = std::ranges::all_of(cells, [&](std::size_t i) {
      return i == *nearest || distance_of(i) >= distance_of(*nearest) + kWord;
    });
    return alone ? std::optional(*nearest) : std::nullopt;
  }

  static bool IsVoltage(const CsvChannel& channel) { return channel.name.ends_with("_v"); }

  /// What was read otherwise than it is written, column by column.
  void Tell() {
    for (std::size_t i = 0; i < columns_.cells.size(); ++i) {
      CsvColumn& column = columns_.cells[i];
      const std::string& name = titles_[i].name;
      if (column.channel != nullptr && !column.unknown_unit.empty()) {
        LeaveOut(i, "was ignored: " + UnitText(column));
      }
      if (name.empty()) continue;  // of a separator at the end
      std::string told = titles_[i].left_out;
      if (column.channel != nullptr && name == column.channel->name) continue;
      if (column.channel != nullptr) told = "was read as " + std::string(column.channel->name);
      const std::string question = told.empty() ? Question(column, name) : "";
      if (told.empty()) told = "is not known and was ignored" + question;
      const std::string note = "column '" + Shown(name) + "' " + told;
      columns_.notes.push_back(std::string(names_.file) + ": " + note);
      if (!question.empty()) columns_.questions.push_back(note);
    }
  }

  /// Of a column with the unit of a channel that the file lacks.
  std::string Question(const CsvColumn& column, const std::string& name) {
    if (!AdviceOnNames(name).empty())
      return "; uc_v is the duty x the supply: is that in the file?";
    if (column.position && !found_[kSpeedChannel]) {
      return "; it is a position: its difference over the period is the speed";
    }
    if (column.unit_of == nullptr || found_[PlaceOf(column.unit_of)]) return "";
    const std::string channel(column.unit_of->name);
    return "; is it " + channel + "? Then call it so";
  }

  static std::string UnitText(const CsvColumn& column) {
    return "unit '" + Shown(column.unknown_unit) + "' is not known for " +
           std::string(column.channel->name) + "; expected " +
           std::string(UnitsOf(*column.channel));
  }

  Error Missing(std::size_t channel) const {
    for (std::size_t i = 0; i < columns_.cells.size(); ++i) {
      const CsvColumn& column = columns_.cells[i];
      // Of a file without any measurement each is missing.
      const bool measured =
          channel == kUmChannel && (column.channel == &kCsvChannelTable[kCurrentChannel] ||
                                    column.channel == &kCsvChannelTable[kSpeedChannel]);
      const bool missing = column.channel == &kCsvChannelTable[channel] || measured;
      if (!missing || column.unknown_unit.empty()) continue;
      return Fail(titles_[i].name, "csv_unit_unknown", UnitText(column));
    }
    const std::string_view missing = kCsvChannelTable[channel].name;
    std::string message =
        "missing: " + ColumnsTaken() + "; expected " + std::string(kColumnsWanted);
    message += AdviceOnNames(names_.text);
    if (channel == 0) message += names_.without_time;
    if (channel == kUmChannel) message += WhatIsLeft();
    for (std::size_t i = 0; i < columns_.cells.size(); ++i) {
      if (!columns_.cells[i].position || found_[kSpeedChannel]) continue;
      message += "; '" + Shown(titles_[i].name) +
                 "' is a position: write its difference over the period as n_rpm";
      break;
    }
    return Fail(missing, "csv_column_missing", message);
  }

  /// "y" of the identification of systems may be anything.
  std::string WhatIsLeft() const {
    std::string left;
    for (std::size_t i = 0; i < columns_.cells.size(); ++i) {
      if (columns_.cells[i].channel != nullptr || titles_[i].name.empty()) continue;
      left += (left.empty() ? "" : " or ") + ("'" + Shown(titles_[i].name) + "'");
    }
    if (left.empty()) return "";
    return "; is " + left + " measured? Call a speed n_rpm, n_rad/s or n_deg/s, a current ia_a";
  }

  /// What each cell of the header was taken for.
  std::string ColumnsTaken() const {
    std::string taken;
    for (std::size_t i = 0; i < columns_.cells.size(); ++i) {
      const CsvColumn& column = columns_.cells[i];
      taken += (taken.empty() ? "'" : ", '") + Shown(titles_[i].name) + "' was taken for " +
               (column.channel != nullptr ? std::string(column.channel->name) : "nothing");
    }
    return taken;
  }

  const NamesLine names_;
  CsvColumns columns_;
  std::vector<Title> titles_;  ///< by place
  std::array<bool, kCsvChannelTable.size()> found_{};
};

}  // namespace

Result<CsvColumns> ReadColumns(const NamesLine& names) {
  return NamesReader(names).Run();
}

Error NoHeader(const NamesLine& first) {
  return CsvError(first.file,
                  first.number,
                  "",
                  "csv_no_header",
                  "no header: the first line is '" + Shown(first.text) +
                      "'; put a line with the columns' names above it, for example t_s,uc_v,um_v");
}

Result<bool> TakeUnits(const NamesLine& line, std::vector<CsvColumn>& cells) {
  struct Found {
    std::string_view text;
    std::optional<double> factor;
  };
  std::vector<Found> units;
  std::size_t known = 0;
  std::string_view rest = line.text;
  for (bool more = true; more && units.size() < cells.size();) {
    const std::string_view unit = TakeCell(line.separator, rest, more);
    const CsvColumn& column = cells[units.size()];
    const bool number = ParseCell(line.separator, unit) || ParseClock(line.separator, unit);
    if (number && column.channel != nullptr) return false;
    std::optional<double> factor;
    if (column.channel != nullptr) factor = UnitFactor(column, unit);
    if (factor) ++known;
    units.push_back({unit, factor});
  }
  if (units.size() != cells.size() || known == 0) return false;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    CsvColumn& column = cells[i];
    if (column.channel == nullptr) continue;
    if (column.has_unit) {
      if (!units[i].factor || *units[i].factor == column.factor) continue;
      return CsvError(line.file,
                      line.number,
                      column.channel->name,
                      "csv_unit_unknown",
                      "the title names another unit than the row of units, '" +
                          Shown(units[i].text) + "': take one of them away");
    }
    if (!units[i].factor && !units[i].text.empty()) {
      return CsvError(line.file,
                      line.number,
                      column.channel->name,
                      "csv_unit_unknown",
                      "unit '" + Shown(units[i].text) + "' is not known; expected " +
                          std::string(UnitsOf(*column.channel)));
    }
    column.factor = units[i].factor.value_or(column.factor);
  }
  return true;
}

}  // namespace faultlab::server

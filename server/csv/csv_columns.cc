#include "server/csv/csv_columns.h"

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

constexpr std::size_t kColumnsMax = 64;

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
      if (columns_.cells.size() == kColumnsMax) {
        return Fail(
            "", "csv_columns_full", "more than " + std::to_string(kColumnsMax) + " columns");
      }
      if (std::optional<Error> error = AddColumn(name)) return *error;
    }
    if (numbers_alone) return NoHeader(names_);
    if (std::optional<Error> error = TakeVoltage()) return *error;
    for (std::size_t i = 0; i < kCsvChannelTable.size(); ++i) {
      if (found_[i]) {
        columns_.channels.emplace_back(kCsvChannelTable[i].name);
      } else if (kCsvChannelTable[i].required &&
                 !(i == kUmChannel && HasMeasurement([&](std::size_t at) { return found_[at]; }))) {
        return MissingColumn(kCsvChannelTable[i].name);
      }
    }
    return std::move(columns_);
  }

 private:
  Error Fail(std::string_view column, std::string reason, const std::string& message) const {
    return CsvError(names_.file, names_.number, column, std::move(reason), message);
  }

  std::optional<Error> AddColumn(std::string_view name) {
    const CsvColumn column = ParseColumnName(name);
    columns_.cells.push_back(column);
    if (column.either) {
      voltages_.push_back({columns_.cells.size() - 1, Shown(name)});
      columns_.cells.back().channel = nullptr;
      return std::nullopt;
    }
    if (column.channel == nullptr) {
      if (name.empty()) return std::nullopt;  // of a separator at the end
      columns_.notes.push_back(std::string(names_.file) + ": column '" + Shown(name) +
                               "' is not known and was ignored");
      return std::nullopt;
    }
    const std::string_view canonical = column.channel->name;
    const auto at = static_cast<std::size_t>(column.channel - kCsvChannelTable.data());
    if (!column.unknown_unit.empty()) return UnknownUnit(column, Shown(name));
    if (found_[at]) {
      return Fail(canonical, "csv_column_twice", "appears twice in the header, expected once");
    }
    found_[at] = true;
    if (name != canonical) {
      columns_.notes.push_back(std::string(names_.file) + ": column '" + Shown(name) +
                               "' was read as " + std::string(canonical));
    }
    return std::nullopt;
  }

  /// "Voltage" and speed alone: the voltage is the command. Otherwise nobody knows which it is.
  std::optional<Error> TakeVoltage() {
    const bool alone = voltages_.size() == 1 && !found_[kCommandChannel] && !found_[kUmChannel];
    for (const auto& [at, name] : voltages_) {
      CsvColumn& column = columns_.cells[at];
      if (alone) {
        column.channel = &kCsvChannelTable[kCommandChannel];
        found_[kCommandChannel] = true;
        if (!column.unknown_unit.empty()) return UnknownUnit(column, name);
      }
      columns_.notes.push_back(
          std::string(names_.file) + ": column '" + name +
          (alone ? "' was read as uc_v" : "' could be uc_v or um_v and was ignored: say which"));
    }
    return std::nullopt;
  }

  Error UnknownUnit(const CsvColumn& column, const std::string& name) const {
    return Fail(name,
                "csv_unit_unknown",
                "unit '" + Shown(column.unknown_unit) + "' is not known for " +
                    std::string(column.channel->name) + "; expected " +
                    std::string(UnitsOf(*column.channel)));
  }

  Error MissingColumn(std::string_view missing) const {
    std::string message =
        "missing: " + ColumnsTaken() + "; expected " + std::string(kColumnsWanted);
    message += AdviceOnNames(names_.text);
    return Fail(missing, "csv_column_missing", message);
  }

  /// What each cell of the header was taken for.
  std::string ColumnsTaken() const {
    std::string_view rest = names_.text;
    std::string taken;
    bool more = true;
    for (const CsvColumn& column : columns_.cells) {
      const std::string_view name = TakeCell(names_.separator, rest, more);
      taken += (taken.empty() ? "'" : ", '") + Shown(name) + "' was taken for " +
               (column.channel != nullptr ? std::string(column.channel->name) : "nothing");
    }
    return taken;
  }

  const NamesLine names_;
  CsvColumns columns_;
  std::array<bool, kCsvChannelTable.size()> found_{};
  /// Places and names of columns that could be uc or um.
  std::vector<std::pair<std::size_t, std::string>> voltages_;
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

bool TakeUnits(std::string_view line, char separator, std::vector<CsvColumn>& cells) {
  std::vector<double> factors;
  for (bool more = true; more;) {
    std::string_view unit = TakeCell(separator, line, more);
    if (unit.size() > 2 && (unit.front() == '[' || unit.front() == '(')) {
      unit = unit.substr(1, unit.size() - 2);
    }
    if (factors.size() == cells.size()) return false;
    const CsvColumn& column = cells[factors.size()];
    const std::optional<double> factor =
        column.channel != nullptr ? UnitFactor(*column.channel, unit) : column.factor;
    if (!factor) return false;
    factors.push_back(*factor);
  }
  if (factors.size() != cells.size()) return false;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (!cells[i].has_unit) cells[i].factor = factors[i];
  }
  return true;
}

}  // namespace faultlab::server

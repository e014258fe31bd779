#include "server/csv/csv_format.h"

#include <algorithm>
#include <array>
#include <boost/json.hpp>
#include <cctype>
#include <charconv>
#include <cmath>
#include <optional>

#include "core/types/utf8.h"
#include "server/csv/csv_channels.h"
#include "server/csv/csv_text.h"
#include "server/csv/csv_time_base.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using core::Error;
using core::Result;
using namespace std::literals;

constexpr std::size_t kFirstLinesBytes = 64 << 10;
constexpr std::size_t kLooked = 4096;

struct Format {
  std::string_view begins;  ///< bytes; of a text in small letters
  std::string_view advice;
};
/// Of bytes that are no text.
constexpr std::array<Format, 15> kBinary = {
    {{"MATLAB 7.3"sv,
      "this is a MAT file of version 7.3: write its signals as CSV, for example with writetable, "
      "or "
      "save it again with -v6 and read it with scipy.io.loadmat"},
     {"MATLAB 5.0"sv, "this is a MAT file: write its signals as CSV, for example with writetable"},
     {"\x89HDF"sv, "this is an HDF5 file: write its signals as CSV, for example with pandas"},
     {"\x93NUMPY"sv,
      "this is an array of NumPy: write it with numpy.savetxt(.., delimiter=',', "
      "header='t_s,uc_v,um_v', comments='')"},
     {"TDSm"sv,
      "this is a TDMS file of LabVIEW: write its channels as text, for example with npTDMS and "
      "pandas"},
     {"PAR1"sv, "this is a Parquet file: write it with pandas.read_parquet(..).to_csv(..)"},
     {"\x80\x02"sv, "this is a pickle of Python: load it there and write it with to_csv"},
     {"\x80\x03"sv, "this is a pickle of Python: load it there and write it with to_csv"},
     {"\x80\x04"sv, "this is a pickle of Python: load it there and write it with to_csv"},
     {"\x80\x05"sv, "this is a pickle of Python: load it there and write it with to_csv"},
     {"PK\x03\x04"sv, "this is a workbook or an archive, not text: save its sheet as CSV"},
     {"\xD0\xCF\x11\xE0"sv, "this is a workbook of an older Excel: save its sheet as CSV"},
     {"SQLite format 3"sv, "this is a database of SQLite: write the table as CSV (.mode csv)"},
     {"%PDF"sv, "this is a PDF: save the table itself as CSV"},
     {"\x1F\x8B"sv, "this is compressed once more: unpack it, or call the file .csv.gz"}}};

/// Level 4 begins with small whole numbers: type, rows, columns, imaginary, length of the name.
bool IsMatLevel4(std::string_view bytes) {
  if (bytes.size() < 21) return false;
  const auto number = [&](std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t i = 4; i > 0; --i) {
      value = value << 8U | static_cast<unsigned char>(bytes[4 * at + i - 1]);
    }
    return value;
  };
  const std::uint32_t length = number(4);
  return number(0) < 100 && number(1) > 0 && number(3) <= 1 && length > 1 && length < 64 &&
         20 + length <= bytes.size() && bytes[20 + length - 1] == '\0';
}

std::string_view AdviceOnBytes(std::string_view bytes) {
  const auto* const known = std::ranges::find_if(
      kBinary, [&](const Format& each) { return bytes.starts_with(each.begins); });
  if (known != kBinary.end()) return known->advice;
  if (IsMatLevel4(bytes)) {
    return "this is a MAT file of level 4: write its signals as CSV, for example with writetable";
  }
  const bool zero = bytes.substr(0, kLooked).find('\0') != std::string_view::npos;
  return zero ? "this is no text: save the signals as CSV, with a row of names above them" : "";
}

std::string CellText(const json::value& value) {
  if (const auto* text = value.if_string()) {
    std::string quoted = "\"";
    for (const char c : *text) quoted += c == '"' ? "\"\""s : std::string(1, c);
    return quoted + '"';
  }
  return value.is_null() || value.is_structured() ? "" : json::serialize(value);
}

/// "NaN", "-nan(ind)", "inf", "None": what JSON does not have, but many programs write.
bool IsLostReading(std::string_view word) {
  double value = 0.0;
  const char* const end = word.data() + word.size();
  const std::from_chars_result read = std::from_chars(word.data(), end, value);
  const bool number = read.ec == std::errc() && read.ptr == end;
  return !word.empty() && (number ? !std::isfinite(value) : IsAbsent(word));
}

/// Those as JSON has them.
std::string WithoutNaN(std::string_view text) {
  std::string out;
  bool quoted = false;
  while (!text.empty()) {
    const std::size_t word = std::min(text.find_first_of("{}[],:\" \t\r\n"), text.size());
    if (!quoted && word > 0) {
      out += IsLostReading(text.substr(0, word)) ? "null" : text.substr(0, word);
      text.remove_prefix(word);
      continue;
    }
    const std::size_t size = quoted && text.front() == '\\' && text.size() > 1 ? 2 : 1;
    if (text.front() == '"') quoted = !quoted;
    out += text.substr(0, size);
    text.remove_prefix(size);
  }
  return out;
}

/// A list of objects with the same members, or an object of lists; nullopt for anything else.
std::optional<std::string> TableOf(const json::value& value) {
  std::string out;
  std::vector<std::string_view> names;
  const auto begin = [&](const json::object& object) {
    for (const auto& member : object) names.push_back(member.key());
    for (std::size_t i = 0; i < names.size(); ++i) {
      out += (i > 0 ? "," : "") + CellText(json::string(names[i]));
    }
    out += '\n';
  };
  if (const auto* rows = value.if_array(); rows != nullptr && !rows->empty()) {
    json::object all;  // a lost reading may have no member
    for (const json::value& row : *rows) {
      if (!row.is_object()) return std::nullopt;
      for (const auto& member : row.get_object()) {
        if (all.size() <= kCsvColumnsMax) all.emplace(member.key(), nullptr);
      }
    }
    begin(all);
    for (const json::value& row : *rows) {
      const auto* const object = row.if_object();
      for (std::size_t i = 0; i < names.size(); ++i) {
        const json::value* const cell = object->if_contains(names[i]);
        out += (i > 0 ? "," : "") + (cell != nullptr ? CellText(*cell) : "");
      }
      out += '\n';
    }
    return out;
  }
  const auto* const columns = value.if_object();
  if (columns == nullptr || columns->empty()) return std::nullopt;
  std::size_t rows = 0;
  for (const auto& column : *columns) {
    if (!column.value().is_array()) return std::nullopt;
    rows = std::max(rows, column.value().get_array().size());
  }
  begin(*columns);
  for (std::size_t row = 0; row < rows; ++row) {
    bool first = true;
    for (const auto& column : *columns) {
      const json::array& cells = column.value().get_array();
      out += (first ? "" : ",") + (row < cells.size() ? CellText(cells[row]) : "");
      first = false;
    }
    out += '\n';
  }
  return out;
}

/// Whether the first two lines are one cell in quotes each, with several cells within.
bool IsQuotedByLine(std::string_view text) {
  LineCursor lines(text);
  for (int i = 0; i < 2; ++i) {
    const std::string_view whole = lines.Next().value_or("");
    const std::string_view line = Trim(whole);
    const bool quoted = line.size() < whole.size() && whole.find('"') != std::string_view::npos &&
                        line.find('"') == std::string_view::npos &&
                        line.find_first_of(",;\t") != std::string_view::npos;
    if (!quoted) return false;
  }
  return true;
}

/// "t:0.00,u:2": every cell of the line begins with a name.
bool HasNamesInCells(std::string_view line) {
  const auto cells =
      1 + std::ranges::count_if(line, [](char c) { return c == ',' || c == ';' || c == '\t'; });
  std::ptrdiff_t named = 0;
  std::string_view rest = line;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find_first_of(",;\t"), rest.size());
    const std::string_view cell = Trim(rest.substr(0, end));
    const std::size_t mark = cell.find_first_of(":=");
    const bool word = mark != std::string_view::npos && mark > 0 &&
                      std::isalpha(static_cast<unsigned char>(cell.front())) != 0;
    if (word && ParseCell(';', Trim(cell.substr(mark + 1)))) ++named;
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return cells > 1 && named == cells;
}

}  // namespace

std::string AdviceOnFormat(std::string_view text) {
  constexpr std::array<Format, 9> kFormats = {
      {{"labview measurement",
        "this is a LabVIEW measurement file: write it as text with one row of names above the "
        "numbers, for example t_s,uc_v,um_v (X_Value is the time)"},
       {"record length",
        "this looks like an oscilloscope's export: delete the columns of its settings, and put the "
        "names of the others above them, for example t_s,uc_v,um_v"},
       {"model,",
        "this looks like an oscilloscope's export: keep the rows of numbers, and put the names of "
        "the columns above them, for example t_s,uc_v,um_v"},
       {"{",
        "this is JSON, and no list of rows or columns: write [{\"t_s\":0,\"uc_v\":2,\"um_v\":5}, "
        "..], or "
        "a row of names and then a row for each sample, as CSV"},
       {"[",
        "this is JSON, and no list of rows or columns: write [{\"t_s\":0,\"uc_v\":2,\"um_v\":5}, "
        "..], or "
        "a row of names and then a row for each sample, as CSV"},
       {"<!doctype", "this is a web page: save the table itself as CSV"},
       {"<html", "this is a web page: save the table itself as CSV"},
       {"<table", "this is a web page: save the table itself as CSV"},
       {"<?xml", "this is XML: save the table itself as CSV"}}};
  const std::string_view first = LineCursor(text.substr(0, kFirstLinesBytes)).Next().value_or("");
  const std::string_view line = Trim(first);
  for (const Format& format : kFormats) {
    if (BeginsWith(line, format.begins)) return std::string(format.advice);
  }
  if (IsQuotedByLine(text.substr(0, kFirstLinesBytes))) {
    return "each line is one cell in quotes: take the quotes at its ends away";
  }
  if (HasNamesInCells(line)) {
    return "each cell has its name in it: write the names once, in a row above the numbers, for "
           "example t_s,uc_v,um_v";
  }
  return {};
}

Result<CsvText> ReadableText(std::string_view bytes, std::string_view name) {
  const auto fail = [&](std::string reason, const std::string& message) {
    return CsvError(name, 1, "", std::move(reason), message);
  };
  if (bytes.starts_with("\xFF\xFE") || bytes.starts_with("\xFE\xFF")) {
    return fail("csv_not_utf8", "the text is UTF-16, expected UTF-8; save the file as CSV UTF-8");
  }
  if (const std::string_view advice = AdviceOnBytes(bytes); !advice.empty()) {
    return fail("csv_other_format", std::string(advice));
  }
  CsvText out;
  const std::string prefix = std::string(name) + ": ";
  if (bytes.starts_with("\xEF\xBB\xBF")) bytes.remove_prefix(3);
  out.bytes = bytes;
  const auto is_high = [](char c) { return static_cast<unsigned char>(c) >= 0x80; };
  if (std::ranges::any_of(bytes, is_high) && !core::IsUtf8(bytes)) {
    out.made = core::FromWindows1252(bytes);
    out.guessed = true;
    out.notes.push_back(prefix + "the file is no UTF-8 and was read as Windows-1252");
  }
  if (bytes.find('\n') == std::string_view::npos && bytes.find('\r') != std::string_view::npos) {
    if (!out.made) out.made = bytes;
    std::ranges::replace(*out.made, '\r', '\n');
  }
  const std::string_view text = out.text();
  const std::size_t first = std::min(text.find_first_not_of(" \t\r\n"), text.size());
  if (text.substr(first, 1) == "[" || text.substr(first, 1) == "{") {
    boost::system::error_code failed;
    json::value value = json::parse(text, failed);
    if (failed) value = json::parse(WithoutNaN(text), failed);
    std::optional<std::string> table = failed ? std::nullopt : TableOf(value);
    if (table) {
      out.made = std::move(table);
      out.notes.push_back(prefix + "JSON was read as a table; its row 1 is line 2");
    }
  }
  return out;
}

}  // namespace faultlab::server

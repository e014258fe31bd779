#include "server/csv/csv_header.h"

#include <algorithm>
#include <array>
#include <map>
#include <utility>
#include <vector>

#include "core/types/utf8.h"
#include "server/csv/csv_text.h"
#include "server/csv/csv_words.h"

namespace faultlab::server {
namespace {

constexpr std::size_t kPieceMin = 3;  ///< letters of a word within a longer one
constexpr std::size_t kWordMax = 40;
constexpr int kUnitAloneDistance = 18;
constexpr int kFarther = 40;
constexpr std::string_view kBetweenWords = " \t_.-/#";
/// "in", before a unit.
constexpr std::array<std::string_view, 7> kIn = {"in", "en", "em", "w", "v", "u", "i"};

const std::map<std::string_view, Says>& Vocabulary() {
  static const std::map<std::string_view, Says> kVocabulary = [] {
    std::map<std::string_view, Says> words;
    for (const Words& each : kWords) {
      std::string_view rest = each.words;
      while (!rest.empty()) {
        const std::size_t end = std::min(rest.find(' '), rest.size());
        words.try_emplace(rest.substr(0, end), each.says);
        rest.remove_prefix(std::min(end + 1, rest.size()));
      }
    }
    return words;
  }();
  return kVocabulary;
}

std::string_view Stripped(std::string_view text) {
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '_'; };
  while (!text.empty() && (blank(text.front()) || text.front() == '%')) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

/// "rad_s", "rad.s-1", "min^-1" as the table has them.
std::string NormalUnit(std::string_view unit) {
  std::string normal = core::PlainLetters(unit);
  std::erase_if(normal, [](char c) { return c == ' ' || c == '.' || c == '*' || c == '^'; });
  std::ranges::replace(normal, '_', '/');
  return normal;
}

const Unit* FindUnit(std::string_view text) {
  const std::string normal = NormalUnit(text);
  const auto found = std::ranges::find(kUnits, normal, &Unit::name);
  return found == kUnits.end() ? nullptr : &*found;
}

/// The unit at the end of a channel's plain name: "t_s" -> "s".
std::string_view OwnUnit(const CsvChannel& channel) {
  return channel.name.substr(channel.name.find('_') + 1);
}

const CsvChannel* Channel(std::string_view name) {
  return std::ranges::find(kCsvChannelTable, name, &CsvChannel::name);
}

/// "MotorSpeed" is two words.
std::string WithBlanks(std::string_view text) {
  std::string out;
  for (const char c : text) {
    const bool begins =
        c >= 'A' && c <= 'Z' && !out.empty() && out.back() >= 'a' && out.back() <= 'z';
    if (begins) out += ' ';
    out += c;
  }
  return out;
}

/// Words that are written as one, from the end on: "motorspannung", "setvoltage", "umotor", "uc".
bool TakeApart(std::string_view word,
               std::vector<Says>& out,
               bool first = true,
               bool after_symbol = false) {
  if (word.empty()) return true;
  const auto& vocabulary = Vocabulary();
  for (std::size_t size = word.size(); size > 0; --size) {
    const bool symbol = first && size == 1 && std::string_view("uvin").find(word[0]) != word.npos;
    const bool index = after_symbol && size == word.size();  // "um", but not "nm"
    if (size < kPieceMin && !symbol && !index) continue;
    const auto found = vocabulary.find(word.substr(0, size));
    if (found == vocabulary.end()) continue;
    const bool says_whose = found->second == Says::kCommand || found->second == Says::kMotor ||
                            found->second == Says::kAmplifier;
    if (size < kPieceMin && index && !says_whose) continue;  // "vdc", "vel"
    out.push_back(found->second);
    if (TakeApart(word.substr(size), out, false, symbol && word[0] != 'n')) return true;
    out.pop_back();
  }
  return false;
}

/// What the words of a title say together.
struct Said {
  bool known = true;  ///< each of its words
  int words = 0;
  std::array<bool, 13> says{};
  bool Has(Says what) const { return says.at(static_cast<std::size_t>(what)); }
};

Said Read(std::string_view text) {
  Said said;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find_first_of(kBetweenWords), text.size());
    const std::string_view word = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (word.empty()) continue;
    ++said.words;
    std::vector<Says> parts;
    const auto found = Vocabulary().find(word);
    if (found != Vocabulary().end()) {
      parts = {found->second};
    } else if (word.size() > kWordMax || !TakeApart(word, parts)) {
      said.known = false;
    }
    for (const Says each : parts) said.says.at(static_cast<std::size_t>(each)) = true;
  }
  return said;
}

/// Before a unit of turns "w" is a speed.
Said SaidBy(std::string_view words, const Unit* unit) {
  Said said = Read(words);
  if (words != "w" || unit == nullptr || unit->base != "rpm") return said;
  said.known = true;
  said.says.at(static_cast<std::size_t>(Says::kAngularSpeed)) = true;
  return said;
}

struct Meaning {
  const CsvChannel* channel = nullptr;
  bool either = false;
  bool by_unit = false;  ///< the unit says so, not the words
};

/// Words that say enough by themselves.
constexpr std::array<std::string_view, 7> kAlone = {
    "input", "output", "command", "cmd", "control", "commande", "upravljanje"};

/// What is measured, if that is a channel of a recording.
Meaning MeaningOf(std::string_view words, const Unit* unit) {
  const Said said = SaidBy(words, unit);
  const bool speed = said.Has(Says::kSpeed) || said.Has(Says::kAngularSpeed);
  const int quantities = (said.Has(Says::kTime) ? 1 : 0) + (said.Has(Says::kVoltage) ? 1 : 0) +
                         (said.Has(Says::kCurrent) ? 1 : 0) + (speed ? 1 : 0) +
                         (said.Has(Says::kDelta) ? 1 : 0);
  // "theta_dot (rad/s)"; pulses a second are none
  const bool turns = unit != nullptr && unit->base == "rpm" && unit->factor != 60.0;
  if (!said.known || quantities > 1) return {};
  if (said.Has(Says::kPosition) && !speed) return {turns ? Channel("n_rpm") : nullptr, false, true};
  const bool asked_for = said.Has(Says::kCommand);
  const bool measured = !asked_for && !said.Has(Says::kReference);
  const bool place = said.Has(Says::kMotor) || said.Has(Says::kAmplifier);
  if (said.Has(Says::kTime)) return {measured && !place ? Channel("t_s") : nullptr};
  if (said.Has(Says::kCurrent)) return {measured ? Channel("ia_a") : nullptr};
  if (speed) return {measured ? Channel("n_rpm") : nullptr};
  if (quantities == 0 && turns && measured)
    return {Channel("n_rpm"), false, true};  // "feedback [rpm]"
  if (said.Has(Says::kDelta)) return {measured && !place ? Channel("delta_s") : nullptr};
  const bool volts = unit != nullptr && unit->base == "v";  // "motor [V]"
  const bool alone = unit == nullptr && std::ranges::find(kAlone, words) != kAlone.end();
  const bool voltage = said.Has(Says::kVoltage) || volts || alone;
  if (!voltage || said.Has(Says::kReference)) return {};
  if (asked_for) return {Channel("uc_v")};
  if (said.Has(Says::kMotor)) return {Channel("um_v")};
  if (said.Has(Says::kAmplifier)) return {Channel("ua_v")};
  return {said.Has(Says::kVoltage) ? Channel("uc_v") : nullptr, true};
}

struct Title {
  std::string words;  ///< without the unit
  const Unit* unit = nullptr;
  std::string unknown_unit;  ///< in brackets
};

std::string PlainWords(std::string_view text) {
  return core::PlainLetters(WithBlanks(text));
}

/// "hh:mm:ss.fff", "UTC: h:min:s", "yyyy-MM-dd HH:mm": how a clock is written.
bool IsClockFormat(std::string_view text) {
  constexpr std::array<std::string_view, 9> kParts = {
      "min", "sec", "hour", "utc", "gmt", "am", "pm", "tt", "of"};
  if (text.find(':') == std::string_view::npos) return false;
  std::string plain = core::PlainLetters(text);
  std::ranges::replace_if(
      plain,
      [](char c) { return std::string_view(":., -/_").find(c) != std::string_view::npos; },
      ' ');
  std::string_view rest = plain;
  bool more = true;
  while (more) {
    const std::string_view part = TakeCell(' ', rest, more);
    const bool one_letter =
        part.empty() || (part.find_first_not_of(part[0]) == std::string_view::npos &&
                         std::string_view("hmsfzydt0").find(part[0]) != std::string_view::npos);
    if (!one_letter && std::ranges::find(kParts, part) == kParts.end()) return false;
  }
  return true;
}

/// What brackets hold: a unit, more words, or both ("V: setpoint", "CH1: mV").
void TakeBrackets(std::string_view within, Title& title) {
  if (IsClockFormat(within)) return;
  if (within == "%") title.unknown_unit = within;  // of a supply, or of a full speed
  std::string words;
  bool known = true;
  for (std::string_view rest = within; !rest.empty();) {
    const std::size_t colon = std::min(rest.find(':'), rest.size());
    const std::string_view part = Stripped(rest.substr(0, colon));
    rest.remove_prefix(std::min(colon + 1, rest.size()));
    const Unit* const unit = FindUnit(part);
    if (unit != nullptr) {
      title.unit = unit;
    } else if (Read(PlainWords(part)).known) {
      words += ' ' + PlainWords(part);
    } else {
      known = false;
    }
  }
  if (title.unit != nullptr || known) {
    title.words += words;
  } else {
    title.unknown_unit = within;
  }
}

/// "n [rpm]".
Title WithoutBrackets(std::string_view cell) {
  const std::size_t open = std::min(cell.find_first_of("[({"), cell.size());
  const std::size_t close = std::min(cell.find_first_of("])}", open), cell.size());
  Title title;
  title.words = PlainWords(cell.substr(0, open));
  if (close > open) {
    title.words += PlainWords(cell.substr(std::min(close + 1, cell.size())));
    TakeBrackets(Trim(cell.substr(open + 1, close - open - 1)), title);
  }
  title.words = Stripped(title.words);
  return title;
}

/// "n_rpm", "t in ms": the longest end that is a unit, and fits what the words before it name:
/// "u_a" is no voltage in ampere.
void TakeUnitAtEnd(Title& title) {
  for (std::size_t at = 1; at < title.words.size(); ++at) {
    if (std::string_view(" _/.").find(title.words[at]) == std::string_view::npos) continue;
    const std::string_view all = title.words;
    const std::string_view end = Stripped(all.substr(at + 1));
    const std::size_t blank = std::min(end.find(' '), end.size());
    const bool begins_with_in =
        blank < end.size() && std::ranges::find(kIn, end.substr(0, blank)) != kIn.end();
    const Unit* const unit = begins_with_in ? nullptr : FindUnit(end);  // "u s" is no "us"
    if (unit == nullptr) continue;
    std::string_view before = Stripped(all.substr(0, at));
    const std::size_t last = before.rfind(' ');
    const bool in = last != std::string_view::npos &&
                    std::ranges::find(kIn, before.substr(last + 1)) != kIn.end();
    // "Vreme u s", but not "Motor I mA".
    const CsvChannel* const without =
        in ? MeaningOf(before.substr(0, last), unit).channel : nullptr;
    if (without != nullptr && OwnUnit(*without) == unit->base) before = before.substr(0, last);
    if (before.ends_with(',')) before.remove_suffix(1);  // "t, s"
    const CsvChannel* const channel = MeaningOf(before, unit).channel;
    const bool fits = channel != nullptr && OwnUnit(*channel) == unit->base;
    if (!fits && SaidBy(before, unit).known) continue;
    title.unit = unit;
    title.words = std::string(before);
    return;
  }
}

Title TitleOf(std::string_view cell) {
  Title title = WithoutBrackets(cell);
  if (title.unit == nullptr && title.unknown_unit.empty()) TakeUnitAtEnd(title);
  return title;
}

/// "ms", "rpm", "volts": what is called by its unit has it. As a unit is written: "Us" is a supply,
/// "Ns" the speed of a field, "U_min" the least voltage.
const Unit* UnitAlone(std::string_view cell) {
  constexpr std::array<std::string_view, 7> kShort = {"ms", "us", "ns", "mV", "mA", "mv", "ma"};
  constexpr std::string_view kSubscript = "\xE2\x82";  // "nₛ"
  if (cell.size() < 2 || cell.find('_') != std::string_view::npos) return nullptr;
  if (cell.find(kSubscript) != std::string_view::npos) return nullptr;
  if (cell.size() == 2 && std::ranges::find(kShort, cell) == kShort.end()) return nullptr;
  const Unit* const unit = FindUnit(cell);
  return unit != nullptr && unit->factor != 60.0 ? unit : nullptr;  // "min" is also the least
}

/// Turns, unless it is of an angular speed, which counts radians.
double FactorOf(const Unit& unit, bool angular) {
  const bool per_second = unit.name == "1/s" || unit.name == "s-1";
  return angular && per_second ? kRpmOfRadPerSecond : unit.factor;
}

/// How far a title is from the plain name of its channel. One letter may be anything, such as a
/// counter of the rows; a unit makes a title sure.
int DistanceOf(const Said& said, std::string_view words, bool has_unit, double factor) {
  constexpr int kFar = 20;
  constexpr int kWord = 8;
  constexpr int kLetter = 6;
  constexpr int kUnit = 10;
  const bool letter = words.find_first_of(kBetweenWords) == 1 || words.size() == 1;
  return kFar + kWord * (said.words - 1) + (letter ? kLetter : 0) - (has_unit ? kUnit : 0) +
         (factor != 1.0 ? 1 : 0);
}

const CsvChannel* ChannelOf(const Unit& unit) {
  return Channel(unit.base == "s"     ? "t_s"
                 : unit.base == "a"   ? "ia_a"
                 : unit.base == "rpm" ? "n_rpm"
                                      : "uc_v");
}

}  // namespace

std::optional<double> UnitFactor(const CsvColumn& column, std::string_view unit) {
  const bool brackets = unit.size() > 2 && (unit.front() == '[' || unit.front() == '(');
  const Unit* const found = FindUnit(brackets ? unit.substr(1, unit.size() - 2) : unit);
  if (found == nullptr || found->base != OwnUnit(*column.channel)) return std::nullopt;
  return FactorOf(*found, column.angular);
}

std::string_view UnitsOf(const CsvChannel& channel) {
  const std::string_view base = OwnUnit(channel);
  return base == "s"     ? "s, ms, us, ns or min"
         : base == "a"   ? "A or mA"
         : base == "rpm" ? "rpm, 1/min, min-1, U/min, tr/min, o/min, rps, Hz, 1/s, rad/s or deg/s"
                         : "V or mV";
}

CsvColumn ParseColumnName(std::string_view cell) {
  CsvColumn column;
  cell = Stripped(cell);
  const auto* const plain = std::ranges::find(kCsvChannelTable, cell, &CsvChannel::name);
  if (plain != kCsvChannelTable.end()) {
    column.channel = plain;
    column.has_unit = true;
    return column;
  }
  if (const Unit* const unit = UnitAlone(cell)) {
    column.channel = ChannelOf(*unit);
    column.either = unit->base == "v";
    column.unit_alone = true;
    column.factor = unit->factor;
    column.has_unit = true;
    column.distance = kUnitAloneDistance + (unit->factor == 1.0 ? 0 : 1);
    // "Sekunde" beside "Zeit" is the second of a minute.
    if (unit->base == "s" && unit->factor == 1.0 && unit->name.size() > 4) column.distance += 4;
    if (cell == "ma" || cell == "mv") column.distance += kFarther;  // "ma" is also a mean
    return column;
  }
  std::string one_line(cell);
  std::ranges::replace(one_line, '\n', ' ');
  std::ranges::replace(one_line, '\r', ' ');
  Title title = TitleOf(one_line);
  if (title.words == "x_value" || title.words == "x value") title.words = "time";  // LabVIEW
  const Said said = SaidBy(title.words, title.unit);
  const Meaning meaning = MeaningOf(title.words, title.unit);
  column.channel = meaning.channel;
  column.either = meaning.either && column.channel != nullptr;
  column.position = said.Has(Says::kPosition);
  if (column.channel == nullptr) {
    if (title.unit != nullptr) column.unit_of = ChannelOf(*title.unit);
    return column;
  }
  column.angular = said.Has(Says::kAngularSpeed) || said.Has(Says::kAngular);
  if (column.angular) column.factor = kRpmOfRadPerSecond;
  const bool stamp = title.words == "stamp" || title.words == "header.stamp";  // of ROS
  column.unit_alone = stamp && title.unit != nullptr;
  if (title.unit == nullptr) {
    column.unknown_unit = title.unknown_unit;
  } else if (title.unit->base == OwnUnit(*column.channel)) {
    column.has_unit = true;
    column.factor = FactorOf(*title.unit, column.angular);
  } else {
    column.unknown_unit = title.unit->name;
  }
  column.distance = DistanceOf(said, title.words, column.has_unit, column.factor);
  if (meaning.by_unit) column.distance += kFarther;
  // "T" is a temperature, unless it is in seconds.
  if (cell == "T" && !column.has_unit) column.distance += kFarther;
  return column;
}

}  // namespace faultlab::server

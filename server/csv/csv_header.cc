#include "server/csv/csv_header.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <numbers>
#include <utility>

namespace faultlab::server {
namespace {

/// Of a name that could be the command or what the motor gets.
constexpr std::string_view kVoltage = "uc_v or um_v";

/// Of a speed that is in rad/s where no unit is named.
constexpr std::string_view kAngular = "n_rpm of rad/s";

struct Alias {
  std::string_view name;  ///< lower case, without blanks and underscores
  std::string_view channel;
};
constexpr std::array<Alias, 70> kAliases = {{{"t", "t_s"},
                                             {"time", "t_s"},
                                             {"timestamp", "t_s"},
                                             {"zeit", "t_s"},
                                             {"vreme", "t_s"},
                                             {"uc", "uc_v"},
                                             {"u", "uc_v"},
                                             {"ucmd", "uc_v"},
                                             {"ucontrol", "uc_v"},
                                             {"input", "uc_v"},
                                             {"um", "um_v"},
                                             {"umotor", "um_v"},
                                             {"vm", "um_v"},
                                             {"vmotor", "um_v"},
                                             {"output", "um_v"},
                                             {"ua", "ua_v"},
                                             {"va", "ua_v"},
                                             {"uamp", "ua_v"},
                                             {"uout", "ua_v"},
                                             {"ia", "ia_a"},
                                             {"i", "ia_a"},
                                             {"im", "ia_a"},
                                             {"imotor", "ia_a"},
                                             {"current", "ia_a"},
                                             {"n", "n_rpm"},
                                             {"rpm", "n_rpm"},
                                             {"speed", "n_rpm"},
                                             {"nout", "n_rpm"},
                                             {"nrpm", "n_rpm"},
                                             {"drehzahl", "n_rpm"},
                                             {"brzina", "n_rpm"},
                                             {"delta", "delta_s"},
                                             // as people of other languages write them
                                             {"temps", "t_s"},
                                             {"tiempo", "t_s"},
                                             {"tempo", "t_s"},
                                             {"xvalue", "t_s"},
                                             {"sollspannung", "uc_v"},
                                             {"stellspannung", "uc_v"},
                                             {"steuerspannung", "uc_v"},
                                             {"commande", "uc_v"},
                                             {"upravljanje", "uc_v"},
                                             {"setvoltage", "uc_v"},
                                             {"motorsetvoltage", "uc_v"},
                                             {"controlvoltage", "uc_v"},
                                             {"motorspannung", "um_v"},
                                             {"motorvoltage", "um_v"},
                                             {"tensionmoteur", "um_v"},
                                             {"naponmotora", "um_v"},
                                             {"ankerspannung", "ua_v"},
                                             {"strom", "ia_a"},
                                             {"motorstrom", "ia_a"},
                                             {"ankerstrom", "ia_a"},
                                             {"motorcurrent", "ia_a"},
                                             {"courant", "ia_a"},
                                             {"struja", "ia_a"},
                                             {"corriente", "ia_a"},
                                             {"vitesse", "n_rpm"},
                                             {"geschwindigkeit", "n_rpm"},
                                             {"velocity", "n_rpm"},
                                             {"motorvelocity", "n_rpm"},
                                             {"motorspeed", "n_rpm"},
                                             {"omega", kAngular},
                                             {"angularvelocity", kAngular},
                                             {"angularspeed", kAngular},
                                             {"voltage", kVoltage},
                                             {"volts", kVoltage},
                                             {"spannung", kVoltage},
                                             {"tension", kVoltage},
                                             {"voltaje", kVoltage},
                                             {"napon", kVoltage}}};

struct Unit {
  std::string_view name;  ///< lower case
  std::string_view base;  ///< unit of the channel that it belongs to
  double factor;
};
constexpr double kRpmOfRadPerSecond = 30.0 / std::numbers::pi;
constexpr std::array<Unit, 35> kUnits = {{{"s", "s", 1.0},
                                          {"sec", "s", 1.0},
                                          {"second", "s", 1.0},
                                          {"seconds", "s", 1.0},
                                          {"ms", "s", 1e-3},
                                          {"msec", "s", 1e-3},
                                          {"us", "s", 1e-6},
                                          {"v", "v", 1.0},
                                          {"volt", "v", 1.0},
                                          {"volts", "v", 1.0},
                                          {"mv", "v", 1e-3},
                                          {"a", "a", 1.0},
                                          {"amp", "a", 1.0},
                                          {"amps", "a", 1.0},
                                          {"ma", "a", 1e-3},
                                          {"rpm", "rpm", 1.0},
                                          {"1/min", "rpm", 1.0},
                                          {"min-1", "rpm", 1.0},
                                          {"o/min", "rpm", 1.0},
                                          {"rps", "rpm", 60.0},
                                          {"rad/s", "rpm", kRpmOfRadPerSecond},
                                          {"1/s", "rpm", 60.0},
                                          {"hz", "rpm", 60.0},
                                          {"rev/s", "rpm", 60.0},
                                          {"u/min", "rpm", 1.0},
                                          {"tr/min", "rpm", 1.0},
                                          {"ob/min", "rpm", 1.0},
                                          {"r/min", "rpm", 1.0},
                                          {"rev/min", "rpm", 1.0},
                                          {"upm", "rpm", 1.0},
                                          {"rads-1", "rpm", kRpmOfRadPerSecond},
                                          {"rad/sec", "rpm", kRpmOfRadPerSecond},
                                          {"deg/s", "rpm", 1.0 / 6.0},
                                          {"degs-1", "rpm", 1.0 / 6.0},
                                          {"\xC2\xB0/s", "rpm", 1.0 / 6.0}}};

std::string Lower(std::string_view text) {
  std::string lower;
  for (std::size_t i = 0; i < text.size(); ++i) {
    // The two UTF-8 spellings of the micro sign.
    if (text.substr(i, 2) == "\xC2\xB5" || text.substr(i, 2) == "\xCE\xBC") {
      lower += 'u';
      ++i;
      continue;
    }
    lower += static_cast<char>(std::tolower(static_cast<unsigned char>(text[i])));
  }
  return lower;
}

std::string_view Stripped(std::string_view text) {
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '_'; };
  while (!text.empty() && blank(text.front())) {
    text.remove_prefix(1);
  }
  while (!text.empty() && blank(text.back())) {
    text.remove_suffix(1);
  }
  return text;
}

/// The channel, and whether the name fits another one too.
struct Named {
  const CsvChannel* channel = nullptr;
  bool either = false;
  bool angular = false;
};

Named FindName(std::string_view name) {
  std::string bare(name);
  std::erase_if(bare, [](char c) { return c == ' ' || c == '_' || c == '.'; });
  const auto alias = std::ranges::find(kAliases, bare, &Alias::name);
  if (alias == kAliases.end()) return {};
  const bool either = alias->channel == kVoltage;
  const bool angular = alias->channel == kAngular;
  const std::string_view channel = either ? "uc_v" : angular ? "n_rpm" : alias->channel;
  return {std::ranges::find(kCsvChannelTable, channel, &CsvChannel::name), either, angular};
}

const CsvChannel* FindChannel(std::string_view name) {
  return FindName(name).channel;
}

/// "rad_s", "rad.s-1", "min^-1" as the table has them.
std::string NormalUnit(std::string_view unit) {
  std::string normal = Lower(unit);
  std::erase_if(normal, [](char c) { return c == ' ' || c == '.' || c == '*' || c == '^'; });
  std::replace(normal.begin(), normal.end(), '_', '/');
  return normal;
}

/// The unit at the end of a channel's plain name: "t_s" -> "s".
std::string_view OwnUnit(const CsvChannel& channel) {
  return channel.name.substr(channel.name.find('_') + 1);
}

/// "uc [v]" -> {"uc", "v"}; an empty unit when there is none.
std::pair<std::string_view, std::string_view> SplitUnit(std::string_view name) {
  const std::size_t open = name.find_first_of("[({");
  if (open != std::string_view::npos) {
    const std::size_t close = std::min(name.find_first_of("])}", open), name.size());
    return {Stripped(name.substr(0, open)), Stripped(name.substr(open + 1, close - open - 1))};
  }
  // "n/rpm", "t in ms", "um mv", "time_ms": the second part is a unit only if the first is a name.
  for (std::size_t at = 1; at < name.size(); ++at) {
    const char c = name[at];
    if ((c != '/' && c != ' ' && c != '_') ||
        FindChannel(Stripped(name.substr(0, at))) == nullptr) {
      continue;
    }
    std::string_view unit = Stripped(name.substr(at + 1));
    if (unit.starts_with("in ")) {
      unit = Stripped(unit.substr(3));
    }
    if (!unit.empty() && FindChannel(name) == nullptr) {
      return {Stripped(name.substr(0, at)), unit};
    }
  }
  return {name, {}};
}

}  // namespace

std::optional<double> UnitFactor(const CsvChannel& channel, std::string_view unit) {
  const std::string normal = NormalUnit(unit);
  for (const Unit& one : kUnits) {
    if (one.name == normal && one.base == OwnUnit(channel)) {
      return one.factor;
    }
  }
  return std::nullopt;
}

std::string_view UnitsOf(const CsvChannel& channel) {
  const std::string_view base = OwnUnit(channel);
  return base == "s"     ? "s, ms or us"
         : base == "a"   ? "A or mA"
         : base == "rpm" ? "rpm, 1/min, min-1, U/min, tr/min, o/min, rps, Hz, 1/s, rad/s or deg/s"
                         : "V or mV";
}

CsvColumn ParseColumnName(std::string_view cell) {
  CsvColumn column;
  const std::string lower = Lower(cell);
  const auto [name, unit] = SplitUnit(Stripped(lower));
  const Named named = FindName(name);
  column.channel = named.channel;
  column.either = named.either;
  if (named.angular) column.factor = kRpmOfRadPerSecond;
  if (column.channel == nullptr || unit.empty()) {
    return column;
  }
  column.has_unit = true;
  if (const std::optional<double> factor = UnitFactor(*column.channel, unit)) {
    column.factor = *factor;
  } else {
    column.unknown_unit = std::string(unit);
  }
  return column;
}

char FindSeparator(std::string_view header) {
  for (const char separator : {';', '\t', ','}) {
    bool quoted = false;
    for (const char c : header) {
      if (c == '"') quoted = !quoted;
      if (c == separator && !quoted) return separator;
    }
  }
  return Stripped(header).find(' ') != std::string_view::npos ? ' ' : ',';
}

}  // namespace faultlab::server

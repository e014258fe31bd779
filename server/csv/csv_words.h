#pragma once

#include <array>
#include <cstdint>
#include <numbers>
#include <string_view>

// The words of the titles of recordings, without accents and in small letters, and their units.
namespace faultlab::server {

/// What a word of a title says.
enum class Says : std::uint8_t {
  kTime,
  kVoltage,
  kCurrent,
  kSpeed,
  kAngularSpeed,  ///< in rad/s where no unit is named
  kDelta,
  kPosition,
  kAngular,
  kCommand,    ///< what is asked for: a control voltage; no measurement
  kReference,  ///< the same, but not of a voltage
  kMotor,      ///< at the motor
  kAmplifier,  ///< at the amplifier's output, before the motor
  kMore        ///< how it was measured; says nothing about what it is
};

struct Words {
  Says says;
  std::string_view words;
};

/// English, German, French, Spanish, Portuguese, Italian, Polish, Czech, Serbian, Turkish, Dutch,
/// the Nordic languages, Hungarian and Romanian.
inline constexpr std::array<Words, 13> kWords = {{
    {Says::kTime,
     "t time times timestamp stamp elapsed clock zeit zeitstempel uhrzeit vreme temps tiempo tempo "
     "czas cas zaman tijd tid aika ido timp millis micros"},
    {Says::kVoltage,
     "u v voltage voltages volt volts spannung tension tensao voltaje tensione napiecie napeti "
     "napon gerilim gerilimi spanning jannite feszultseg tensiune"},
    {Says::kCurrent,
     "i current currents amp amps ampere amperes strom stroom courant corriente corrente prad "
     "proud struja akim akimi virta aram curent"},
    {Says::kSpeed,
     "n speed speeds velocity velocities rpm drehzahl geschwindigkeit vitesse velocidad velocidade "
     "velocita predkosc obroty rychlost otacky brzina hiz hizi devir devri snelheid toerental "
     "hastighed hastighet nopeus fordulatszam sebesseg viteza turatie revolutions vel nrpm nout"},
    {Says::kAngularSpeed, "omega winkelgeschwindigkeit"},
    {Says::kDelta, "delta"},
    {Says::kPosition,
     "angle theta phi position pos winkel ugao angolo angulo posicao posicion posizione pozicija "
     "aci encoder ticks counts rotation rotazione rotacion rotacao otaceni donme rotatie rotasjon"},
    {Says::kAngular, "dot angular angulaire angolare ugaona katowa acisal"},
    {Says::kCommand,
     "c cmd command commanded control ctrl set soll sollwert stell steuer input in commande "
     "consigne upravljanje zadani zadana zadane entrada ingresso wejscie vstup giris ulaz ulazni "
     "target desired demand setpoint"},
    {Says::kReference, "ref reference referencia"},
    {Says::kMotor,
     "m mot motor motors moteur motore motora motoru silnika terminal terminals klemme klemmen "
     "output"},
    {Says::kAmplifier, "a out amplifier anker armature ankers induit indotto twornika rotora"},
    {Says::kMore,
     "measured meas measurement feedback fb now actual act real true ist istwert shaft rotor filt "
     "filtered filter smooth smoothed value val signal sensor avg average mean raw adc analog "
     "channel dc eff effective rms header of the in de du del des da do di la le el gemessen "
     "gemessene mesure mesuree medida medido misurata misurato zmierzony zmierzona zmierzone "
     "olculen izmereno izmeren izmerena merena mereni mereno rotational obrotowa"},
}};

struct Unit {
  std::string_view name;  ///< as it is compared: without blanks, dots, stars and carets, '_' as '/'
  std::string_view base;  ///< unit of the channel that it belongs to
  double factor;
};
inline constexpr double kRpmOfRadPerSecond = 30.0 / std::numbers::pi;
inline constexpr std::array<Unit, 67> kUnits = {{{"s", "s", 1.0},
                                                 {"sec", "s", 1.0},
                                                 {"secs", "s", 1.0},
                                                 {"second", "s", 1.0},
                                                 {"seconds", "s", 1.0},
                                                 {"sekunden", "s", 1.0},
                                                 {"sekunde", "s", 1.0},
                                                 {"sekunder", "s", 1.0},
                                                 {"secondes", "s", 1.0},
                                                 {"segundos", "s", 1.0},
                                                 {"secondi", "s", 1.0},
                                                 {"sekundy", "s", 1.0},
                                                 {"saniye", "s", 1.0},
                                                 {"sn", "s", 1.0},
                                                 {"ms", "s", 1e-3},
                                                 {"msec", "s", 1e-3},
                                                 {"millis", "s", 1e-3},
                                                 {"milliseconds", "s", 1e-3},
                                                 {"us", "s", 1e-6},
                                                 {"usec", "s", 1e-6},
                                                 {"micros", "s", 1e-6},
                                                 {"microseconds", "s", 1e-6},
                                                 {"ns", "s", 1e-9},
                                                 {"nsec", "s", 1e-9},
                                                 {"nsecs", "s", 1e-9},
                                                 {"nanosec", "s", 1e-9},
                                                 {"nanoseconds", "s", 1e-9},
                                                 {"min", "s", 60.0},
                                                 {"minutes", "s", 60.0},
                                                 {"v", "v", 1.0},
                                                 {"volt", "v", 1.0},
                                                 {"volts", "v", 1.0},
                                                 {"mv", "v", 1e-3},
                                                 {"a", "a", 1.0},
                                                 {"amp", "a", 1.0},
                                                 {"amps", "a", 1.0},
                                                 {"ampere", "a", 1.0},
                                                 {"ma", "a", 1e-3},
                                                 {"rpm", "rpm", 1.0},
                                                 {"1/min", "rpm", 1.0},
                                                 {"min-1", "rpm", 1.0},
                                                 {"o/min", "rpm", 1.0},
                                                 {"u/min", "rpm", 1.0},
                                                 {"tr/min", "rpm", 1.0},
                                                 {"ob/min", "rpm", 1.0},
                                                 {"obr/min", "rpm", 1.0},
                                                 {"ot/min", "rpm", 1.0},
                                                 {"rot/min", "rpm", 1.0},
                                                 {"giri/min", "rpm", 1.0},
                                                 {"dev/dk", "rpm", 1.0},
                                                 {"d/dk", "rpm", 1.0},
                                                 {"f/min", "rpm", 1.0},
                                                 {"omw/min", "rpm", 1.0},
                                                 {"r/min", "rpm", 1.0},
                                                 {"rev/min", "rpm", 1.0},
                                                 {"upm", "rpm", 1.0},
                                                 {"rps", "rpm", 60.0},
                                                 {"1/s", "rpm", 60.0},
                                                 {"s-1", "rpm", 60.0},
                                                 {"hz", "rpm", 60.0},
                                                 {"rev/s", "rpm", 60.0},
                                                 {"rad/s", "rpm", kRpmOfRadPerSecond},
                                                 {"rads-1", "rpm", kRpmOfRadPerSecond},
                                                 {"rad/sec", "rpm", kRpmOfRadPerSecond},
                                                 {"deg/s", "rpm", 1.0 / 6.0},
                                                 {"degs-1", "rpm", 1.0 / 6.0},
                                                 {"deg/sec", "rpm", 1.0 / 6.0}}};

}  // namespace faultlab::server

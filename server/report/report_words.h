#pragma once

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>

namespace faultlab::server {

enum class Language { kEnglish, kSerbian, kSerbianCyrillic };

/// "en", "sr" (Latin script), "sr-Cyrl".
std::optional<Language> ParseLanguage(std::string_view name);

/// All texts of a report in one language. {0}, {1}.. are filled in.
class ReportWords {
 public:
  explicit ReportWords(Language language) : language_(language) {}

 private:
  std::string Say(std::string_view english, std::string_view serbian) const;
  Language language_;  // the texts below need it

 public:
  /// Between the whole part of a number and its decimals.
  char decimal_sign = language_ == Language::kEnglish ? '.' : ',';
  std::string report =
      Say("Report of a run", "Izveštaj o ogledu");  ///< the kind of document, above its title
  std::string run = Say("Run", "Ogled");
  std::string made_by = Say("Made by", "Izveo");
  std::string guest = Say("guest", "gost");
  std::string time = Say("Time", "Vreme");
  std::string rig = Say("Rig", "Uređaj");
  std::string uploaded = Say("uploaded recording", "otpremljen snimak");
  std::string bench = Say("Bench", "Sto");
  std::string description = Say("{0}, description {1}", "{0}, opis {1}");
  std::string state_finished = Say("finished", "završen");
  std::string state_stopped = Say("stopped", "zaustavljen");
  std::string state_failed = Say("failed", "nije uspeo");
  std::string state_interrupted = Say("interrupted", "prekinut");
  std::string samples = Say("{0}, every {1} ms: {2} s", "{0}, na svakih {1} ms: {2} s");
  std::string samples_name = Say("Samples", "Uzorci");
  std::string excitation = Say("Excitation", "Pobuda");
  std::string control = Say("Speed control", "Upravljanje brzinom");
  std::string control_steps =
      Say("steps between {0} and {1} rpm, each held for {2} s, from {3} s on",
          "skokovi između {0} i {1} rpm, svaki traje {2} s, od {3} s");
  std::string control_ramp = Say("ramps between {0} and {1} rpm of {2} s each, from {3} s on",
                                 "rampe između {0} i {1} rpm od po {2} s, od {3} s");
  std::string control_prbs = Say("PRBS between {0} and {1} rpm, a bit lasts {2} s, from {3} s on",
                                 "PRBS između {0} i {1} rpm, bit traje {2} s, od {3} s");
  std::string control_made_up = Say("Made up for", "Kompenzovano");
  std::string control_since = Say("{0} since {1} s", "{0} od {1} s");
  std::string control_deviation = Say("Deviation", "Odstupanje");
  std::string control_judged = Say("integral {0} rad, steady {1} rpm, from {2} s on",
                                   "integral {0} rad, u stacionarnom stanju {1} rpm, od {2} s");
  std::string control_alone = Say("Without compensation", "Bez kompenzacije");
  std::string control_never = Say("the speed was not kept", "brzina nije održavana");
  std::string replay_of = Say("Replay of", "Ponovljen snimak");
  std::string calibration = Say("Calibration", "Kalibracija");
  std::string calibrated_on_run =
      Say("on this recording, {0} s to {1} s", "na ovom snimku, od {0} s do {1} s");
  std::string calibrated_before = Say("of {0}, stored with the rig", "od {0}, sačuvana uz uređaj");
  std::string calibration_none = Say("none", "nema je");
  std::string delta = Say("Delay δ", "Kašnjenje δ");
  std::string noise = Say("Noise (1 σ)", "Šum (1 σ)");
  std::string false_alarms = Say("{0} a day over all tests", "{0} dnevno, svi testovi zajedno");
  std::string false_alarms_name = Say("False alarms", "Lažne uzbune");

  std::string faults =
      Say("Faults as the rig switched them", "Kvari kako ih je uređaj uključio");  ///< heading
  std::string faults_none =
      Say("No component was switched.", "Nijedna komponenta nije promenjena.");
  std::string sealed =
      Say("Sealed: this run is of an exercise and is opened when the exercise is released.",
          "Zapečaćeno: ovaj ogled je deo vežbe i otvara se kada se vežba objavi.");
  std::string faults_more =
      Say("And {0} more; the JSON export has all.", "I još {0}; sve su u JSON datoteci.");
  std::string at_time = Say("Time, s", "Vreme, s");  ///< columns
  std::string at_sample = Say("Sample", "Uzorak");
  std::string component = Say("Component", "Komponenta");
  std::string value = Say("Value", "Vrednost");
  std::string rig_says = Say("Rig", "Uređaj");
  std::string confirmed = Say("confirmed", "potvrđeno");
  std::string refused = Say("refused", "odbijeno");
  std::string unconfirmed = Say("not confirmed", "nije potvrđeno");
  std::string nominal = Say("nominal", "nominalno");

  std::string verdict = Say("Verdict", "Zaključak");
  std::string verdict_fault = Say("Fault: {0}", "Kvar: {0}");
  std::string or_word = Say("or", "ili");
  std::string no_component = Say("no component", "nijedna komponenta");
  std::string verdict_unknown = Say("Unknown fault", "Nepoznat kvar");
  std::string verdict_sensor = Say("Sensor of {0}", "Senzor za {0}");
  std::string verdict_friction = Say("Dry friction", "Suvo trenje");
  std::string verdict_nominal = Say("No fault", "Bez kvara");
  std::string verdict_set_back = Say("{0}; set back", "{0}; vraćeno");
  std::string verdict_not_excited =
      Say("The input is not rich enough for an answer", "Pobuda nije dovoljno bogata za odgovor");
  std::string verdict_none = Say("No verdict", "Nema zaključka");
  std::string unsettled =
      Say("Provisional: the recording ended before the window after the fault was full.",
          "Privremeno: snimak se završio pre nego što se prozor posle kvara napunio.");
  std::string detected = Say("Detected", "Otkriveno");
  std::string detected_again =
      Say("Changed again", "Promenjeno ponovo");  ///< of a further change of the same fault
  std::string earlier = Say("Before that", "Pre toga");
  std::string earlier_is =
      Say("{0}; detected at {1} s, until {2} s", "{0}; otkriveno u {1} s, do {2} s");
  std::string detected_at = Say("at {0} s, by {1}", "u {0} s; otkrio: {1}");
  std::string detector_residual = Say("the residual test", "test ostataka");
  std::string detector_cusum = Say("the CUSUM test", "CUSUM test");
  std::string detector_glr =
      Say("the GLR test over {0} samples", "GLR test preko {0} odbiraka");  ///< over {0} samples
  std::string began_at =
      Say("; the change began at about {0} s", "; promena je počela u oko {0} s");
  std::string standard_error =
      Say("{0} (standard error); nominal {1}", "{0} (standardna greška); nominalno {1}");
  std::string bound = Say("{0}; nominal {1}", "{0}; nominalno {1}");
  std::string group =
      Say("The sensors cannot tell these components apart; each value explains the recording "
          "equally well.",
          "Senzori ne razlikuju ove komponente: svaka vrednost jednako dobro objašnjava snimak.");
  std::string explains =
      Say("what it leaves unexplained is {0} times the noise (1: nothing but noise)",
          "neobjašnjeno je {0} puta koliko i šum (1: samo šum)");
  std::string certainty = Say("Certainty", "Pouzdanost");
  std::string response_gain =
      Say("Gain", "Pojačanje");  ///< of a bench that is diagnosed by its speed, as the two below
  std::string response_time = Say("Time constant", "Vremenska konstanta");
  std::string response_friction = Say("Friction takes", "Trenje odnosi");
  std::string response_is = Say("{0}, before {1}", "{0}, pre toga {1}");
  std::string runner_up = Say("Next best", "Sledeći po redu");
  std::string runner_up_is =
      Say("{0}, explains the readings {1} times worse", "{0}, objašnjava merenja {1} puta lošije");

  std::string path =
      Say("Decision path of the paper’s method (Fig. 21)",
          "Put odlučivanja po metodi iz rada (sl. 21)");  ///< heading: the paper's method
  std::string path_none = Say("No path: no parameter left its band.",
                              "Puta nema: nijedan parametar nije izašao iz svog opsega.");
  std::string yes = Say("yes", "da");
  std::string no = Say("no", "ne");
  std::string step = Say("{0} {1} ({2}, limit {3})", "{0} {1} ({2}, granica {3})");
  std::string leads_to = Say(" → {0}", " → {0}");
  std::string path_agrees = Say("The path ends at {0}, as the verdict does.",
                                "Put se završava kod {0}, kao i zaključak.");
  std::string path_alone = Say("The path ends at {0}.", "Put se završava kod {0}.");
  std::string path_differs = Say("The path ends at {0}, but the verdict is {1}:",
                                 "Put se završava kod {0}, a zaključak je {1}:");
  std::string why_unknown =
      Say("The path ends at {0}, because it knows only single faults. According to the verdict, no "
          "single component explains the recording.",
          "Put se završava kod {0}, jer poznaje samo pojedinačne kvarove. Po zaključku nijedna "
          "komponenta sama ne objašnjava snimak.");  ///< a sentence of its own: {0} is the end of
                                                     ///< the path
  std::string why_settling = Say("the window still holds samples from before the change.",
                                 "prozor još sadrži odbirke od pre promene.");
  std::string why_close =
      Say("the step “{0}” was close to its limit.", "korak „{0}“ bio je blizu granice.");
  std::string why_window =
      Say("the path uses one window and does not know which faults look alike.",
          "put koristi jedan prozor i ne zna koji kvarovi liče jedan na drugi.");

  std::string outside =
      Say("Is {0} outside its band?",
          "Da li je {0} van svog opsega?");  ///< questions of the path: "Is {0} outside its band?"
  std::string opposite = Say("Have {0} and {1} moved in opposite directions?",
                             "Da li su se {0} i {1} pomerili u suprotnim smerovima?");
  std::string same_way = Say("Have {0} and {1} moved in the same direction?",
                             "Da li su se {0} i {1} pomerili u istom smeru?");

  std::string too_early = Say("Too few samples since the change.",
                              "Premalo odbiraka od promene.");  ///< reasons of a verdict
  std::string too_late =
      Say("Something has changed just before the end. Too little follows to say what.",
          "Nešto se promenilo pred sam kraj. Posle toga je premalo podataka da se kaže šta.");
  std::string ends_too_soon = Say(
      "Something may have changed a little. The record ends too soon after the alarm to tell.",
      "Možda se nešto malo promenilo. Snimak se završava prerano posle uzbune da bi se to reklo.");
  std::string worked_out = Say("Something had changed; what, was still being worked out.",
                               "Nešto se promenilo; šta, još se utvrđivalo.");
  std::string no_single = Say("No single component explains the recording.",
                              "Nijedna komponenta sama ne objašnjava snimak.");
  std::string sensor_gain =
      Say("{0} reads {1} times what it should. No component explains this: look at its sensor.",
          "{0} pokazuje {1} puta prave vrednosti. Nijedna komponenta to ne objašnjava: pogledajte "
          "senzor.");
  std::string sensor_high =
      Say("{0} reads {1} too much. No component explains this: look at its sensor.",
          "{0} pokazuje {1} previše. Nijedna komponenta to ne objašnjava: pogledajte senzor.");
  std::string sensor_lost =
      Say("{0} does not follow the motor. No component explains this: look at its sensor.",
          "{0} ne prati motor. Nijedna komponenta to ne objašnjava: pogledajte senzor.");
  std::string friction =
      Say("Dry friction takes {0} mNm, {1} before. No component explains this: look at bearings "
          "and brushes.",
          "Suvo trenje uzima {0} mNm, ranije {1}. Nijedna komponenta to ne objašnjava: pogledajte "
          "ležajeve i četkice.");
  std::string sensor_low =
      Say("{0} reads {1} too little. No component explains this: look at its sensor.",
          "{0} pokazuje {1} premalo. Nijedna komponenta to ne objašnjava: pogledajte senzor.");
  std::string warmed =
      Say("The resistance of the winding has moved by {0} %, as that of a rig that warms up or "
          "runs in does.",
          "Otpor namotaja se promenio za {0} %, kao kod postrojenja koje se zagreva ili uhodava.");
  std::string beside = Say("No single component explains the recording: {0} and also {1}.",
                           "Nijedna komponenta sama ne objašnjava snimak: {0} i još {1}.");
  std::string two =
      Say("Two components have changed together.", "Dve komponente su se promenile zajedno.");

  std::string before_after =
      Say("Estimates before and after each change", "Procene pre i posle svake promene");
  std::string parameter = Say("Parameter", "Parametar");
  std::string before = Say("Before", "Pre");
  std::string after = Say("After", "Posle");
  std::string change = Say("Δ %", "Δ %");
  std::string model = Say("Model", "Model");
  std::string published = Say("Published", "Objavljeno");
  std::string changed_at = Say("{0} at {1} s", "{0} u {1} s");
  std::string change_at = Say("Change at {0} s", "Promena u {0} s");
  std::string no_model = Say("; no model: {0} not nominal either",
                             "; bez modela: ni {0} nije na nominalnoj vrednosti");
  std::string means = Say(
      "Before: mean over the last 5 s before the change. After: mean from when the window holds no "
      "older sample, up to the next change. Model: what the model of the bench predicts.",
      "Pre: srednja vrednost poslednjih 5 s pre promene. Posle: srednja vrednost otkad u prozoru "
      "nema starijih uzoraka, do sledeće promene. Model: šta predviđa model stola.");

  std::string figure_signals = Say("Signals", "Signali");
  std::string figure_swa =
      Say("Estimates by the sliding window (SWA)", "Procene kliznim prozorom (SWA)");
  std::string figure_sia =
      Say("Estimates by sliding integrals (SIA)", "Procene kliznim integralima (SIA)");
  std::string figure_models = Say("Models and measurement", "Modeli i merenje");
  std::string no_figure = Say("{0}: not drawn, {1}.", "{0}: nije nacrtano, {1}.");

  std::string origin = Say("Origin", "Poreklo");
  std::string program = Say("Program", "Program");
  std::string checksum = Say("SHA-256 of the CSV", "SHA-256 za CSV");
  std::string address = Say("Address", "Adresa");
  std::string no_address = Say(
      "No link or QR code: the server’s public address (public_url) is not set.",
      "Bez veze i QR koda: javna adresa servera (public_url) nije podešena.");  ///< what to do so
                                                                                ///< that reports
                                                                                ///< have a link
};

const ReportWords& WordsOf(Language language);

/// The text with {0}, {1}.. replaced.
std::string Fill(std::string_view text, std::initializer_list<std::string_view> values);

}  // namespace faultlab::server

#include "server/report/report_words.h"

#include "server/report/serbian_scripts.h"

namespace faultlab::server {
namespace {

ReportWords English() {
  return {
      .decimal_sign = '.',
      .report = "Report of a run",
      .run = "Run",
      .made_by = "Made by",
      .guest = "guest",
      .time = "Time",
      .rig = "Rig",
      .uploaded = "uploaded recording",
      .bench = "Bench",
      .description = "{0}, description {1}",
      .state = "State",
      .state_finished = "finished",
      .state_stopped = "stopped",
      .state_failed = "failed",
      .state_interrupted = "interrupted",
      .samples = "{0}, every {1} ms: {2} s",
      .samples_name = "Samples",
      .settings = "Settings",
      .excitation = "Excitation",
      .control = "Speed control",
      .control_steps = "steps between {0} and {1} rpm, each held for {2} s, from {3} s on",
      .control_ramp = "ramps between {0} and {1} rpm of {2} s each, from {3} s on",
      .control_prbs = "PRBS between {0} and {1} rpm, a bit lasts {2} s, from {3} s on",
      .control_made_up = "Made up for",
      .control_since = "{0} since {1} s",
      .control_deviation = "Deviation",
      .control_judged = "integral {0} rad, steady {1} rpm, from {2} s on",
      .control_alone = "Without compensation",
      .control_never = "the speed was not kept",
      .replay_of = "Replay of",
      .calibration = "Calibration",
      .calibrated_on_run = "on this recording, {0} s to {1} s",
      .calibrated_before = "of {0}, stored with the rig",
      .calibration_none = "none",
      .delta = "Delay δ",
      .noise = "Noise (1 σ)",
      .false_alarms = "{0} a day over all tests",
      .false_alarms_name = "False alarms",
      .faults = "Faults as the rig switched them",
      .faults_none = "No component was switched.",
      .sealed = "Sealed: this run is of an exercise and is opened when the exercise is released.",
      .faults_more = "And {0} more; the JSON export has all.",
      .at_time = "Time, s",
      .at_sample = "Sample",
      .component = "Component",
      .value = "Value",
      .rig_says = "Rig",
      .confirmed = "confirmed",
      .refused = "refused",
      .unconfirmed = "not confirmed",
      .nominal = "nominal",
      .verdict = "Verdict",
      .verdict_fault = "Fault: {0}",
      .or_word = "or",
      .no_component = "no component",
      .verdict_unknown = "Unknown fault",
      .verdict_sensor = "Sensor of {0}",
      .verdict_nominal = "No fault",
      .verdict_set_back = "{0}; set back",
      .verdict_not_excited = "The input is not rich enough for an answer",
      .verdict_none = "No verdict",
      .unsettled = "Provisional: the recording ended before the window after the fault was full.",
      .detected = "Detected",
      .detected_again = "Changed again",
      .earlier = "Before that",
      .earlier_is = "{0}; detected at {1} s, until {2} s",
      .detected_at = "at {0} s, by {1}",
      .detector_residual = "the residual test",
      .detector_cusum = "the CUSUM test",
      .detector_glr = "the GLR test over {0} samples",
      .began_at = "; the change began at about {0} s",
      .standard_error = "{0} (standard error); nominal {1}",
      .bound = "{0}; nominal {1}",
      .group =
          "The sensors cannot tell these components apart; each value explains the recording "
          "equally well.",
      .explains = "what it leaves unexplained is {0} times the noise (1: nothing but noise)",
      .certainty = "Certainty",
      .response_gain = "Gain",
      .response_time = "Time constant",
      .response_friction = "Friction takes",
      .response_is = "{0}, before {1}",
      .runner_up = "Next best",
      .runner_up_is = "{0}, explains the readings {1} times worse",
      .path = "Decision path of the paper’s method (Fig. 21)",
      .path_none = "No path: no parameter left its band.",
      .yes = "yes",
      .no = "no",
      .step = "{0} {1} ({2}, limit {3})",
      .leads_to = " → {0}",
      .path_agrees = "The path ends at {0}, as the verdict does.",
      .path_alone = "The path ends at {0}.",
      .path_differs = "The path ends at {0}, but the verdict is {1}:",
      .why_unknown =
          "The path ends at {0}, because it knows only single faults. According to the verdict, no "
          "single component explains the recording.",
      .why_settling = "the window still holds samples from before the change.",
      .why_close = "the step “{0}” was close to its limit.",
      .why_window = "the path uses one window and does not know which faults look alike.",
      .outside = "Is {0} outside its band?",
      .opposite = "Have {0} and {1} moved in opposite directions?",
      .same_way = "Have {0} and {1} moved in the same direction?",
      .too_early = "Too few samples since the change.",
      .too_late = "Something has changed just before the end. Too little follows to say what.",
      .ends_too_soon =
          "Something may have changed a little. The record ends too soon after the alarm to tell.",
      .worked_out = "Something had changed; what, was still being worked out.",
      .no_single = "No single component explains the recording.",
      .sensor_gain =
          "{0} reads {1} times what it should. No component explains this: look at its "
          "sensor.",
      .sensor_high = "{0} reads {1} too much. No component explains this: look at its sensor.",
      .sensor_low = "{0} reads {1} too little. No component explains this: look at its sensor.",
      .warmed =
          "The resistance of the winding has moved by {0} %, as that of a rig that warms up does.",
      .beside = "No single component explains the recording: {0} and also {1}.",
      .two = "Two components have changed together.",
      .before_after = "Estimates before and after each change",
      .parameter = "Parameter",
      .before = "Before",
      .after = "After",
      .change = "Δ %",
      .model = "Model",
      .published = "Published",
      .changed_at = "{0} at {1} s",
      .change_at = "Change at {0} s",
      .no_model = "; no model: {0} not nominal either",
      .means =
          "Before: mean over the last 5 s before the change. After: mean from when the window "
          "holds "
          "no older sample, up to the next change. Model: what the model of the bench predicts.",
      .figures = "Figures",
      .figure_signals = "Signals",
      .figure_swa = "Estimates by the sliding window (SWA)",
      .figure_sia = "Estimates by sliding integrals (SIA)",
      .figure_models = "Models and measurement",
      .no_figure = "{0}: not drawn, {1}.",
      .origin = "Origin",
      .program = "Program",
      .checksum = "SHA-256 of the CSV",
      .address = "Address",
      .no_address = "No link or QR code: the server’s public address (public_url) is not set.",
  };
}

/// @param in  writes a text in one of the two scripts
ReportWords Serbian(std::string (*in)(std::string_view)) {
  return {
      .decimal_sign = ',',
      .report = in("Izveštaj o ogledu"),
      .run = in("Ogled"),
      .made_by = in("Izveo"),
      .guest = in("gost"),
      .time = in("Vreme"),
      .rig = in("Uređaj"),
      .uploaded = in("otpremljen snimak"),
      .bench = in("Sto"),
      .description = in("{0}, opis {1}"),
      .state = in("Stanje"),
      .state_finished = in("završen"),
      .state_stopped = in("zaustavljen"),
      .state_failed = in("nije uspeo"),
      .state_interrupted = in("prekinut"),
      .samples = in("{0}, na svakih {1} ms: {2} s"),
      .samples_name = in("Uzorci"),
      .settings = in("Podešavanja"),
      .excitation = in("Pobuda"),
      .control = in("Upravljanje brzinom"),
      .control_steps = in("skokovi između {0} i {1} rpm, svaki traje {2} s, od {3} s"),
      .control_ramp = in("rampe između {0} i {1} rpm od po {2} s, od {3} s"),
      .control_prbs = in("PRBS između {0} i {1} rpm, bit traje {2} s, od {3} s"),
      .control_made_up = in("Kompenzovano"),
      .control_since = in("{0} od {1} s"),
      .control_deviation = in("Odstupanje"),
      .control_judged = in("integral {0} rad, u stacionarnom stanju {1} rpm, od {2} s"),
      .control_alone = in("Bez kompenzacije"),
      .control_never = in("brzina nije održavana"),
      .replay_of = in("Ponovljen snimak"),
      .calibration = in("Kalibracija"),
      .calibrated_on_run = in("na ovom snimku, od {0} s do {1} s"),
      .calibrated_before = in("od {0}, sačuvana uz uređaj"),
      .calibration_none = in("nema je"),
      .delta = in("Kašnjenje δ"),
      .noise = in("Šum (1 σ)"),
      .false_alarms = in("{0} dnevno, svi testovi zajedno"),
      .false_alarms_name = in("Lažne uzbune"),
      .faults = in("Kvari kako ih je uređaj uključio"),
      .faults_none = in("Nijedna komponenta nije promenjena."),
      .sealed = in("Zapečaćeno: ovaj ogled je deo vežbe i otvara se kada se vežba objavi."),
      .faults_more = in("I još {0}; sve su u JSON datoteci."),
      .at_time = in("Vreme, s"),
      .at_sample = in("Uzorak"),
      .component = in("Komponenta"),
      .value = in("Vrednost"),
      .rig_says = in("Uređaj"),
      .confirmed = in("potvrđeno"),
      .refused = in("odbijeno"),
      .unconfirmed = in("nije potvrđeno"),
      .nominal = in("nominalno"),
      .verdict = in("Zaključak"),
      .verdict_fault = in("Kvar: {0}"),
      .or_word = in("ili"),
      .no_component = in("nijedna komponenta"),
      .verdict_unknown = in("Nepoznat kvar"),
      .verdict_sensor = in("Senzor za {0}"),
      .verdict_nominal = in("Bez kvara"),
      .verdict_set_back = in("{0}; vraćeno"),
      .verdict_not_excited = in("Pobuda nije dovoljno bogata za odgovor"),
      .verdict_none = in("Nema zaključka"),
      .unsettled = in("Privremeno: snimak se završio pre nego što se prozor posle kvara napunio."),
      .detected = in("Otkriveno"),
      .detected_again = in("Promenjeno ponovo"),
      .earlier = in("Pre toga"),
      .earlier_is = in("{0}; otkriveno u {1} s, do {2} s"),
      .detected_at = in("u {0} s; otkrio: {1}"),
      .detector_residual = in("test ostataka"),
      .detector_cusum = in("CUSUM test"),
      .detector_glr = in("GLR test preko {0} odbiraka"),
      .began_at = in("; promena je počela u oko {0} s"),
      .standard_error = in("{0} (standardna greška); nominalno {1}"),
      .bound = in("{0}; nominalno {1}"),
      .group = in(
          "Senzori ne razlikuju ove komponente: svaka vrednost jednako dobro objašnjava snimak."),
      .explains = in("neobjašnjeno je {0} puta koliko i šum (1: samo šum)"),
      .certainty = in("Pouzdanost"),
      .response_gain = in("Pojačanje"),
      .response_time = in("Vremenska konstanta"),
      .response_friction = in("Trenje odnosi"),
      .response_is = in("{0}, pre toga {1}"),
      .runner_up = in("Sledeći po redu"),
      .runner_up_is = in("{0}, objašnjava merenja {1} puta lošije"),
      .path = in("Put odlučivanja po metodi iz rada (sl. 21)"),
      .path_none = in("Puta nema: nijedan parametar nije izašao iz svog opsega."),
      .yes = in("da"),
      .no = in("ne"),
      .step = in("{0} {1} ({2}, granica {3})"),
      .leads_to = in(" → {0}"),
      .path_agrees = in("Put se završava kod {0}, kao i zaključak."),
      .path_alone = in("Put se završava kod {0}."),
      .path_differs = in("Put se završava kod {0}, a zaključak je {1}:"),
      .why_unknown = in("Put se završava kod {0}, jer poznaje samo pojedinačne kvarove. Po "
                        "zaključku nijedna komponenta sama ne objašnjava snimak."),
      .why_settling = in("prozor još sadrži odbirke od pre promene."),
      .why_close = in("korak „{0}“ bio je blizu granice."),
      .why_window = in("put koristi jedan prozor i ne zna koji kvarovi liče jedan na drugi."),
      .outside = in("Da li je {0} van svog opsega?"),
      .opposite = in("Da li su se {0} i {1} pomerili u suprotnim smerovima?"),
      .same_way = in("Da li su se {0} i {1} pomerili u istom smeru?"),
      .too_early = in("Premalo odbiraka od promene."),
      .too_late =
          in("Nešto se promenilo pred sam kraj. Posle toga je premalo podataka da se kaže šta."),
      .ends_too_soon = in("Možda se nešto malo promenilo. Snimak se završava prerano posle uzbune "
                          "da bi se to reklo."),
      .worked_out = in("Nešto se promenilo; šta, još se utvrđivalo."),
      .no_single = in("Nijedna komponenta sama ne objašnjava snimak."),
      .sensor_gain =
          in("{0} pokazuje {1} puta prave vrednosti. Nijedna komponenta to ne objašnjava: "
             "pogledajte senzor."),
      .sensor_high = in("{0} pokazuje {1} previše. Nijedna komponenta to ne objašnjava: pogledajte "
                        "senzor."),
      .sensor_low = in("{0} pokazuje {1} premalo. Nijedna komponenta to ne objašnjava: pogledajte "
                       "senzor."),
      .warmed = in("Otpor namotaja se promenio za {0} %, kao kod postrojenja koje se zagreva."),
      .beside = in("Nijedna komponenta sama ne objašnjava snimak: {0} i još {1}."),
      .two = in("Dve komponente su se promenile zajedno."),
      .before_after = in("Procene pre i posle svake promene"),
      .parameter = in("Parametar"),
      .before = in("Pre"),
      .after = in("Posle"),
      .change = in("Δ %"),
      .model = in("Model"),
      .published = in("Objavljeno"),
      .changed_at = in("{0} u {1} s"),
      .change_at = in("Promena u {0} s"),
      .no_model = in("; bez modela: ni {0} nije na nominalnoj vrednosti"),
      .means = in("Pre: srednja vrednost poslednjih 5 s pre promene. Posle: srednja vrednost otkad "
                  "u prozoru "
                  "nema starijih uzoraka, do sledeće promene. Model: šta predviđa model stola."),
      .figures = in("Slike"),
      .figure_signals = in("Signali"),
      .figure_swa = in("Procene kliznim prozorom (SWA)"),
      .figure_sia = in("Procene kliznim integralima (SIA)"),
      .figure_models = in("Modeli i merenje"),
      .no_figure = in("{0}: nije nacrtano, {1}."),
      .origin = in("Poreklo"),
      .program = in("Program"),
      .checksum = in("SHA-256 za CSV"),
      .address = in("Adresa"),
      .no_address = in("Bez veze i QR koda: javna adresa servera (public_url) nije podešena."),
  };
}

}  // namespace

std::optional<Language> ParseLanguage(std::string_view name) {
  if (name == "en") return Language::kEnglish;
  if (name == "sr") return Language::kSerbian;
  if (name == "sr-Cyrl") return Language::kSerbianCyrillic;
  return std::nullopt;
}

const ReportWords& WordsOf(Language language) {
  static const ReportWords kEnglish = English();
  static const ReportWords kLatin =
      Serbian([](std::string_view text) { return std::string(text); });
  static const ReportWords kCyrillic = Serbian(ToCyrillic);
  switch (language) {
    case Language::kSerbian:
      return kLatin;
    case Language::kSerbianCyrillic:
      return kCyrillic;
    case Language::kEnglish:
      break;
  }
  return kEnglish;
}

std::string Fill(std::string_view text, std::initializer_list<std::string_view> values) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const std::size_t number = i + 2 < text.size() && text[i] == '{' && text[i + 2] == '}'
                                   ? static_cast<std::size_t>(text[i + 1] - '0')
                                   : values.size();
    if (number >= values.size()) {
      out += text[i];
      continue;
    }
    out += values.begin()[number];
    i += 2;
  }
  return out;
}

}  // namespace faultlab::server

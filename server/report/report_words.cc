#include "server/report/report_words.h"

namespace faultlab::server {
namespace {

constexpr ReportWords kEnglish = {
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
    .verdict_unknown = "Unknown fault",
    .verdict_nominal = "No fault",
    .verdict_not_excited = "The input is not rich enough for an answer",
    .verdict_none = "No verdict",
    .unsettled = "Provisional: the recording ended before the window after the fault was full.",
    .detected = "Detected",
    .detected_at = "at {0} s, by {1}",
    .began_at = "; the change began at about {0} s",
    .standard_error = "{0} ± {1} (standard error); nominal {2}",
    .bound = "{0}; nominal {1}",
    .group =
        "The sensors cannot tell these components apart; each value explains the recording "
        "equally well.",
    .explains = "the residual is {0} times what noise alone leaves (1: everything is explained)",
    .certainty = "Certainty",
    .runner_up = "Next best",
    .runner_up_is = "{0}, with a residual of {1} times",
    .path = "Decision path of the paper’s method (Fig. 21)",
    .path_none = "No path was taken: no parameter left its band, or the bench is not the paper’s.",
    .yes = "yes",
    .no = "no",
    .step = "{0} {1} ({2}, limit {3})",
    .leads_to = " → {0}",
    .path_agrees = "The path ends at {0}, as the verdict does.",
    .path_alone = "The path ends at {0}.",
    .path_differs = "The path ends at {0}; the verdict is different: {1}.",
    .why_unknown =
        "The verdict found that no single component explains the recording; the path "
        "always ends at one.",
    .why_settling = "The window after the fault was not full yet.",
    .why_close = "The step “{0}” was decided by a number close to its limit.",
    .why_window =
        "The path uses the estimates of one window and the signs of their changes; the "
        "verdict compares the components’ models with all measured channels.",
    .before_after = "Estimates before and after the fault",
    .parameter = "Parameter",
    .before = "Before",
    .after = "After",
    .change = "Change, %",
    .model = "Model",
    .model_for = "Means of the estimates. Model: what the calibrated model predicts for {0}.",
    .means = "Means of the estimates.",
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
};

constexpr ReportWords kSerbian = {
    .report = "Izveštaj o ogledu",
    .run = "Ogled",
    .made_by = "Izveo",
    .guest = "gost",
    .time = "Vreme",
    .rig = "Uređaj",
    .uploaded = "otpremljen snimak",
    .bench = "Sto",
    .description = "{0}, opis {1}",
    .state = "Stanje",
    .state_finished = "završen",
    .state_stopped = "zaustavljen",
    .state_failed = "nije uspeo",
    .state_interrupted = "prekinut",
    .samples = "{0}, na svakih {1} ms: {2} s",
    .samples_name = "Uzorci",
    .settings = "Podešavanja",
    .excitation = "Pobuda",
    .replay_of = "Ponovljen snimak",
    .calibration = "Kalibracija",
    .calibrated_on_run = "na ovom snimku, od {0} s do {1} s",
    .calibrated_before = "od {0}, sačuvana uz uređaj",
    .calibration_none = "nema je",
    .delta = "Kašnjenje δ",
    .noise = "Šum (1 σ)",
    .false_alarms = "{0} dnevno, svi testovi zajedno",
    .false_alarms_name = "Lažne uzbune",
    .faults = "Otkazi kako ih je uređaj uključio",
    .faults_none = "Nijedna komponenta nije promenjena.",
    .faults_more = "I još {0}; sve su u JSON datoteci.",
    .at_time = "Vreme, s",
    .at_sample = "Uzorak",
    .component = "Komponenta",
    .value = "Vrednost",
    .rig_says = "Uređaj",
    .confirmed = "potvrđeno",
    .refused = "odbijeno",
    .unconfirmed = "nije potvrđeno",
    .nominal = "nominalno",
    .verdict = "Zaključak",
    .verdict_fault = "Otkaz: {0}",
    .or_word = "ili",
    .verdict_unknown = "Nepoznat otkaz",
    .verdict_nominal = "Bez otkaza",
    .verdict_not_excited = "Pobuda nije dovoljno bogata za odgovor",
    .verdict_none = "Nema zaključka",
    .unsettled = "Privremeno: snimak se završio pre nego što se prozor posle otkaza napunio.",
    .detected = "Otkriveno",
    .detected_at = "u {0} s, testom {1}",
    .began_at = "; promena je počela u oko {0} s",
    .standard_error = "{0} ± {1} (standardna greška); nominalno {2}",
    .bound = "{0}; nominalno {1}",
    .group = "Senzori ne razlikuju ove komponente: svaka vrednost jednako dobro objašnjava snimak.",
    .explains = "ostatak je {0} puta onoliki koliki ostavlja sam šum (1: sve je objašnjeno)",
    .certainty = "Pouzdanost",
    .runner_up = "Sledeći po redu",
    .runner_up_is = "{0}, sa ostatkom od {1} puta",
    .path = "Put odlučivanja po metodi iz rada (sl. 21)",
    .path_none =
        "Puta nema: nijedan parametar nije izašao iz svog opsega, ili sto nije onaj iz rada.",
    .yes = "da",
    .no = "ne",
    .step = "{0} {1} ({2}, granica {3})",
    .leads_to = " → {0}",
    .path_agrees = "Put se završava kod {0}, kao i zaključak.",
    .path_alone = "Put se završava kod {0}.",
    .path_differs = "Put se završava kod {0}; zaključak je drugačiji: {1}.",
    .why_unknown =
        "Zaključak je da nijedna komponenta sama ne objašnjava snimak; put se uvek "
        "završava kod neke.",
    .why_settling = "Prozor posle otkaza još nije bio pun.",
    .why_close = "Korak „{0}” odlučen je brojem blizu granice.",
    .why_window =
        "Put koristi procene jednog prozora i znake njihovih promena; zaključak poredi "
        "modele komponenti sa svim merenim kanalima.",
    .before_after = "Procene pre i posle otkaza",
    .parameter = "Parametar",
    .before = "Pre",
    .after = "Posle",
    .change = "Promena, %",
    .model = "Model",
    .model_for = "Srednje vrednosti procena. Model: šta kalibrisani model predviđa za {0}.",
    .means = "Srednje vrednosti procena.",
    .figures = "Slike",
    .figure_signals = "Signali",
    .figure_swa = "Procene kliznim prozorom (SWA)",
    .figure_sia = "Procene kliznim integralima (SIA)",
    .figure_models = "Modeli i merenje",
    .no_figure = "{0}: nije nacrtano, {1}.",
    .origin = "Poreklo",
    .program = "Program",
    .checksum = "SHA-256 CSV datoteke",
    .address = "Adresa",
};

}  // namespace

std::optional<Language> ParseLanguage(std::string_view name) {
  if (name == "en") return Language::kEnglish;
  if (name == "sr") return Language::kSerbian;
  return std::nullopt;
}

const ReportWords& WordsOf(Language language) {
  return language == Language::kSerbian ? kSerbian : kEnglish;
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

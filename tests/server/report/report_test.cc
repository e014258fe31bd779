#include "server/report/report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "hardware/bench/benches.h"
#include "server/plots/figures.h"
#include "server/report/sentences.h"
#include "server/report/serbian_scripts.h"
#include "tests/server/report/pdf_reader.h"

namespace faultlab::server {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using tests::PdfReader;
using tests::Squeezed;

core::Component Part(const char* symbol) {
  return *hardware::PaperBench().Find(symbol);
}

core::Result<Figure> Drawn(const std::string& name) {
  if (name == "models") {
    return core::Error{core::ErrorCode::kInvalid, "the recording is too short", "samples"};
  }
  std::vector<core::Sample> samples(200);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i].index = static_cast<std::int64_t>(i);
    samples[i].t_s = 0.01 * static_cast<double>(i);
    samples[i].uc_v = i % 7 < 3 ? 2.0 : 3.0;
    samples[i].um_v = 5.0 + std::sin(0.1 * static_cast<double>(i));
  }
  return MakeSignalsFigure(samples, {});
}

RunReport Sample() {
  RunReport report;
  report.id = "run-abc";
  report.name = "Ogled 3: čšćžđ, Покус, R1";
  report.made_by = "Mila Antić (mila)";
  report.began_at = "2026-11-21T01:02:03.456Z";
  report.ended_at = "2026-11-21T01:02:23.456Z";
  report.state = "finished";
  report.rig = "sim-1";
  report.bench = &hardware::PaperBench();
  report.samples = 2000;
  report.period_s = 0.01;
  report.excitation = "PRBS: low 2 V, high 3 V";
  report.faults = {{10.0, 1000, Part("R1"), 100.0, ReportFault::Said::kConfirmed},
                   {12.0, 1200, Part("Ra"), 9.0, ReportFault::Said::kRefused}};
  core::Verdict& verdict = report.diagnosis.verdict;
  verdict.kind = core::VerdictKind::kFault;
  verdict.detected_at_s = 10.02;
  verdict.onset_s = 9.99;
  verdict.detector = "residual";
  verdict.group = {Part("R1")};
  verdict.candidates = {{Part("R1"), 100.2, 0.11, 0, 1.02, 0.0},
                        {Part("C8"), 3.741e-3, 7e-5, 0, 71.5, 70.5}};
  verdict.path = {{"a1 outside its band?", true, 0.1063, 0.01452, "b0", {}},
                  {"a1 and b0 in opposite directions?", true, 0.1063, 0.0, "R1", {Part("R1")}}};
  verdict.settled = true;
  report.diagnosis.calibration.emplace();
  report.diagnosis.calibration->dated = "2026-11-20T18:22:32.428Z";
  report.diagnosis.calibration->delta_s = 9.542e-3;
  report.diagnosis.calibration->um_noise_v = 15.5e-3;
  report.changes = {{.t_s = 10.0,
                     .component = Part("R1"),
                     .before = 1.0,
                     .value = 100.0,
                     .others = {},
                     .estimates = {{"SWA, K = 100",
                                    {{"b0d", 2.23, 0.2516, 0.2532, 0.2528},
                                     {"b1d", -1.1, -0.66, 1.2e-5, std::nullopt}}}}}};
  report.figures = {"signals", "swa", "sia", "models"};
  report.figure = Drawn;
  report.version = "1.2.3";
  report.csv_sha256 = std::string(64, 'a');
  report.address = "https://lab.example.org/runs/run-abc";
  return report;
}

std::string Pdf(const RunReport& report, Language language = Language::kEnglish) {
  auto pdf = ReportPdf(report, language);
  EXPECT_TRUE(pdf.ok()) << pdf.error().message;
  return pdf.ok() ? pdf.value() : "";
}

TEST(Report, SaysWhatWasMeasuredAndWhatWasFound) {
  const std::string bytes = Pdf(Sample());
  PdfReader pdf(bytes);
  const std::string text = pdf.Text();
  for (const char* said :
       {"Ogled 3: čšćžđ, Покус, R1",
        "Mila Antić (mila)",
        "2026-11-21 01:02:03 UTC",
        "sim-1",
        "PRBS: low 2 V, high 3 V",
        "2000, every 10 ms: 20 s",
        "of 2026-11-20 18:22:32 UTC, stored with the rig",
        "9.542 ms",
        "um 15.5 mV",
        "Fault: R1 ↑",
        "100.20 ± 0.11 Ω (standard error); nominal 1 Ω",
        "C8 = 3.74 ± 0.07 mF, explains the readings 70 times worse",
        "at 10.02 s, by the residual test; the change began at about 9.99 s",
        "Decision path of the paper’s method",
        "Is a1 outside its band? yes (0.1063, limit 0.01452) → b0",
        "Have a1 and b0 moved in opposite directions? yes (0.1063, limit 0) → R1",
        "The path ends at R1, as the verdict does.",
        "10.00 1000 R1 100 Ω confirmed",
        "12.00 1200 Ra 9 Ω refused",
        "R1: 1 Ω → 100 Ω at 10.00 s",
        "b0d SWA, K = 100 2.230 0.2516 −89 0.2532 0.2528",
        "b1d SWA, K = 100 −1.100 −0.6600 −40 1.2·10⁻⁵ –",
        "Models and measurement: not drawn, the recording is too short.",
        "faultlab 1.2.3",
        "https://lab.example.org/runs/run-abc"}) {
    EXPECT_THAT(text, HasSubstr(Squeezed(said)));
  }
  EXPECT_THAT(text, HasSubstr(std::string(64, 'a')));
  EXPECT_EQ(pdf.Pages(), 3);
  EXPECT_THAT(text, HasSubstr(Squeezed("1 / 3")));
  EXPECT_THAT(text, HasSubstr(Squeezed("3 / 3")));
  EXPECT_THAT(pdf.Info(), HasSubstr("(A4)"));
  EXPECT_THAT(bytes, HasSubstr("/URI (https://lab.example.org/runs/run-abc)"));
}

TEST(Report, NamesAllOfAGroupInTheOrderOfTheBench) {
  RunReport report = Sample();
  core::Verdict& verdict = report.diagnosis.verdict;
  verdict.group = {Part("R12"), Part("R9")};
  verdict.candidates = {{Part("R12"), 5590.0, 8.0, 0, 1.016, 0.0},
                        {Part("R9"), 37.5e3, 200.0, 0, 1.016, 0.0},
                        {Part("R1"), 40.69, 1.0, 0, 1857.0, 1856.0}};
  const std::string text = PdfReader(Pdf(report)).Text();
  EXPECT_THAT(text, HasSubstr(Squeezed("Fault: R9 or R12")));
  EXPECT_LT(text.find(Squeezed("R9 37.5 ± 0.2 kΩ")), text.find(Squeezed("R12 5.590 ± 0.008 kΩ")));
  EXPECT_THAT(text,
              HasSubstr(Squeezed("R1 = 40.7 ± 1.0 Ω, explains the readings 1828 times worse")));
}

TEST(Report, OfABenchWithoutAVoltageSaysHowItsMotorAnswers) {
  RunReport report = Sample();
  report.diagnosis.verdict.response =
      core::ResponseChange{{{58.2, 1.3}, {70.7e-3, 3.7e-3}, {11.5, 2.1}},
                           {{72.61, 0.14}, {112.4e-3, 0.9e-3}, {14.3, 2.2}}};
  const std::string text = PdfReader(Pdf(report)).Text();
  for (const char* said : {"Gain 72.61 ± 0.14 rpm/V, before 58.2 ± 1.3 rpm/V",
                           "Time constant 112.4 ± 0.9 ms, before 71 ± 4 ms",
                           "Friction takes 14 ± 2 rpm, before 12 ± 2 rpm"}) {
    EXPECT_THAT(text, HasSubstr(Squeezed(said)));
  }
  EXPECT_THAT(PdfReader(Pdf(report, Language::kSerbian)).Text(),
              HasSubstr(Squeezed("Pojačanje 72,61 ± 0,14 rpm/V, pre toga 58,2 ± 1,3 rpm/V")));
}

TEST(Report, TellsHowASpeedWasKept) {
  RunReport report = Sample();
  report.control = ReportControl{.shape = "steps",
                                 .low_rpm = 376.94,
                                 .high_rpm = 427.2,
                                 .hold_s = 2.0,
                                 .from_s = 5.5,
                                 .made_up = {{9.27, Part("R1"), 56.1}},
                                 .judged = ReportControl::Judged{9.0, 5.424, 0.0861},
                                 .alone = ReportControl::Judged{9.0, 11.3, 4.2}};
  const std::string text = PdfReader(Pdf(report)).Text();
  for (const char* said : {"steps between 376.9 and 427.2 rpm, each held for 2 s, from 5.5 s on",
                           "R1 = 56.1 Ω since 9.27 s",
                           "integral 5.42 rad, steady 0.0861 rpm, from 9.00 s on",
                           "Without compensation integral 11.3 rad, steady 4.2 rpm"}) {
    EXPECT_THAT(text, HasSubstr(Squeezed(said)));
  }
  report.control->judged.reset();
  EXPECT_THAT(PdfReader(Pdf(report, Language::kSerbian)).Text(),
              HasSubstr(Squeezed("brzina nije održavana")));
}

TEST(Report, TellsEachChangeOfAFaultAndTheOnesBefore) {
  RunReport report = Sample();
  core::Verdict& verdict = report.diagnosis.verdict;
  verdict.further = {{14.05, 14.0, "cusum"}};
  core::Verdict earlier = verdict;
  earlier.detected_at_s = 3.02;
  earlier.further.clear();
  earlier.group = {Part("C8")};
  earlier.candidates = {{Part("C8"), 2e-6, 1e-8, 0, 1.0, 0.0}};
  report.story.episodes.resize(2);
  report.story.episodes[0].found = {earlier, core::FaultShape::kAbrupt, 7.04};
  report.story.episodes[1].found = {verdict, core::FaultShape::kAbrupt, std::nullopt};
  ReportChange second = report.changes.front();
  second.t_s = 14.0;
  second.before = 100.0;
  second.value = 33.0;
  second.others = {Part("C8"), Part("R9")};
  report.changes.push_back(second);
  const std::string text = PdfReader(Pdf(report)).Text();
  for (const char* said :
       {"Detected at 10.02 s, by the residual test; the change began at about 9.99 s",
        "Changed again at 14.05 s, by the CUSUM test; the change began at about 14.00 s",
        "Before that Fault: C8 = 2.000 ± 0.010 µF; detected at 3.02 s, until 7.04 s",
        "R1: 1 Ω → 100 Ω at 10.00 s",
        "R1: 100 Ω → 33 Ω at 14.00 s; no model: C8, R9 not nominal either"}) {
    EXPECT_THAT(text, HasSubstr(Squeezed(said)));
  }
}

TEST(Report, WithoutAnAddressSaysWhatToDo) {
  RunReport report = Sample();
  EXPECT_THAT(PdfReader(Pdf(report)).Text(), Not(HasSubstr("public_url")));
  report.address.clear();
  const std::string text = PdfReader(Pdf(report)).Text();
  EXPECT_THAT(text, HasSubstr(Squeezed("No link or QR code")));
  EXPECT_THAT(text, HasSubstr("public_url"));
}

TEST(Report, OfARunWithoutANameIsTitledByItsRigAndTime) {
  RunReport report = Sample();
  report.name.clear();
  EXPECT_THAT(PdfReader(Pdf(report)).Text(1),
              HasSubstr(Squeezed("Report of a run sim-1, 2026-11-21 01:02:03 UTC")));
}

TEST(Report, SpeaksSerbian) {
  const std::string text = PdfReader(Pdf(Sample(), Language::kSerbian)).Text();
  for (const char* said : {"Izveštaj o ogledu",
                           "Uređaj sim-1",
                           "Kvar: R1",
                           "9,542 ms",
                           "100,20 ± 0,11 Ω",
                           "C8 = 3,74 ± 0,07 mF",
                           "10,00 1000 R1 100 Ω",
                           "2,230 0,2516 −89 0,2532",
                           "standardna greška",
                           "Put odlučivanja po metodi iz rada",
                           "Da li je a1 van svog opsega? da (0,1063, granica 0,01452)",
                           "potvrđeno"}) {
    EXPECT_THAT(text, HasSubstr(Squeezed(said)));
  }
  EXPECT_THAT(text, Not(HasSubstr("Verdict")));
}

TEST(Report, SpeaksSerbianInCyrillicScript) {
  const std::string text = PdfReader(Pdf(Sample(), Language::kSerbianCyrillic)).Text();
  for (const char* said : {"Извештај о огледу",
                           "Уређај sim-1",
                           "Квар: R1",
                           "9,542 ms",
                           "100,20 ± 0,11 Ω (стандардна грешка)",
                           "у 10,02 s; открио: тест остатака",
                           "Да ли је a1 ван свог опсега? да (0,1063, граница 0,01452)",
                           "Процене клизним прозором (SWA)",
                           "SHA-256 за CSV",
                           "последњих 5 s пре промене"}) {
    EXPECT_THAT(text, HasSubstr(Squeezed(said)));
  }
}

TEST(Report, WritesSerbianInBothScripts) {
  EXPECT_EQ(ToCyrillic("Džep, LJUBAV, Njegoš, đak"), "Џеп, ЉУБАВ, Његош, ђак");
  EXPECT_EQ(ToCyrillic("od {0} s do {1} s; s tim, 5 ms"), "од {0} s до {1} s; с тим, 5 ms");
  EXPECT_EQ(ToCyrillic("Vreme, s"), "Време, s");
  EXPECT_EQ(ToCyrillic("GLR test preko {0} odbiraka"), "GLR тест преко {0} одбирака");
  EXPECT_EQ(ToCyrillic("public_url u „QR” kodu"), "public_url у „QR” коду");
}

TEST(Report, SaysTheSentencesOfTheDiagnosisInItsLanguage) {
  const ReportWords& serbian = WordsOf(Language::kSerbian);
  EXPECT_EQ(ReasonIn(serbian, "no single component explains the record: beside R1 also J"),
            "Nijedna komponenta sama ne objašnjava snimak: R1 i još J.");
  EXPECT_EQ(ReasonIn(serbian, "no single component explains the record"),
            "Nijedna komponenta sama ne objašnjava snimak.");
  EXPECT_EQ(ReasonIn(serbian, "ia reads 0.03 A too much: its sensor, no component"),
            "ia pokazuje 0.03 A previše. Nijedna komponenta to ne objašnjava: pogledajte senzor.");
  EXPECT_EQ(ReasonIn(serbian,
                     "dry friction takes 0.99 mNm, 0.33 before: bearings or brushes, no component"),
            "Suvo trenje uzima 0.99 mNm, ranije 0.33. Nijedna komponenta to ne objašnjava: "
            "pogledajte ležajeve i četkice.");
  EXPECT_EQ(
      ReasonIn(serbian,
               "the winding has moved by +1.7 %, as that of a rig that warms up or runs in does"),
      "Otpor namotaja se promenio za +1.7 %, kao kod postrojenja koje se zagreva ili uhodava.");
  EXPECT_EQ(ReasonIn(WordsOf(Language::kEnglish),
                     "n reads 1.05 times what it should: its sensor, no component"),
            "n reads 1.05 times what it should. No component explains this: look at its sensor.");
  EXPECT_EQ(ReasonIn(serbian,
                     "something has changed just before the end: too little follows to say what"),
            "Nešto se promenilo pred sam kraj. Posle toga je premalo podataka da se kaže šta.");
  EXPECT_EQ(
      ReasonIn(WordsOf(Language::kEnglish),
               "something may have changed a little: the record ends too soon after the alarm "
               "to tell"),
      "Something may have changed a little. The record ends too soon after the alarm to tell.");
  EXPECT_EQ(ReasonIn(serbian, "of a later version"), "of a later version");
  EXPECT_EQ(QuestionIn(serbian, "b1/a1 and a1 in the same direction?"),
            "Da li su se b1/a1 i a1 pomerili u istom smeru?");
}

TEST(Report, HasNoMinusBeforeNothingAndNoReasonOfAHealthyRig) {
  RunReport report = Sample();
  report.changes.front().estimates.front().rows = {{"b0d", 2.388, 2.379, 0.0787, std::nullopt}};
  report.diagnosis.verdict = {};
  report.diagnosis.verdict.kind = core::VerdictKind::kNominal;
  report.diagnosis.verdict.reason = "the record fits the calibrated rig";
  const std::string text = PdfReader(Pdf(report)).Text(1);
  EXPECT_THAT(text, HasSubstr(Squeezed("2.388 2.379 0 0.07870 –")));
  EXPECT_THAT(text, Not(HasSubstr(Squeezed("fits the calibrated rig"))));
}

TEST(Report, HasItsFiguresOnThePages) {
  PdfReader pdf(Pdf(Sample()));
  EXPECT_LT(pdf.Coloured(1), 0.0001) << "text alone";
  EXPECT_GT(pdf.Coloured(2), 0.002);
  EXPECT_GT(pdf.Coloured(3), 0.001);
}

TEST(Report, HasTheSameBytesEveryTime) {
  const std::string once = Pdf(Sample());
  EXPECT_NE(Pdf(Sample(), Language::kSerbian), once);
  std::vector<std::thread> others;
  std::array<std::string, 3> again;
  for (std::string& bytes : again) others.emplace_back([&bytes] { bytes = Pdf(Sample()); });
  for (std::thread& other : others) other.join();
  for (const std::string& bytes : again) EXPECT_TRUE(bytes == once);
}

TEST(Report, SaysWhyThePathAndTheVerdictDiffer) {
  RunReport report = Sample();
  core::Verdict& verdict = report.diagnosis.verdict;
  verdict.path.back().leads_to = "R12 or C8";
  verdict.path.back().components = {Part("R12"), Part("C8")};
  EXPECT_THAT(PdfReader(Pdf(report)).Text(1),
              HasSubstr(Squeezed("The path ends at R12 or C8, but the verdict is R1: "
                                 "the path uses one window and does not know which")));
  verdict.path.front().threshold = 0.09;
  EXPECT_THAT(PdfReader(Pdf(report)).Text(1),
              HasSubstr(Squeezed("the step “Is a1 outside its band?” was close to its limit.")));
}

TEST(Report, SaysEachStepOfThePathInItsLanguage) {
  RunReport report = Sample();
  core::PathStep& last = report.diagnosis.verdict.path.back();
  const auto serbian = [&] { return PdfReader(Pdf(report, Language::kSerbian)).Text(1); };
  last.leads_to = "R12 or C8";
  last.components = {Part("R12"), Part("C8")};
  EXPECT_THAT(serbian(), HasSubstr(Squeezed("→ R12 ili C8")));
  last.components.clear();
  last.leads_to = "nominal";
  EXPECT_THAT(serbian(), HasSubstr(Squeezed("→ nominalno")));
  last.leads_to = "no component";
  EXPECT_THAT(serbian(), HasSubstr(Squeezed("→ nijedna komponenta")));
}

TEST(Report, StaysOnThreePagesWithManyFaults) {
  RunReport report = Sample();
  for (int i = 0; i < 60; ++i) report.faults.push_back(report.faults.front());
  PdfReader pdf(Pdf(report));
  EXPECT_EQ(pdf.Pages(), 3);
  EXPECT_THAT(pdf.Text(), HasSubstr(Squeezed("And 52 more; the JSON export has all.")));
}

TEST(Report, SetsAnyNameAndAnEmptyDiagnosis) {
  RunReport report;
  report.id = "rec-1";
  report.name = std::string("a\x01\xff\xc0\x80\n(\\)'] 日本 ") + std::string(150, 'W');
  report.address = "https://lab.example.org/it's\\here";
  report.began_at = "2026-11-21T01:02:03.456Z";
  report.bench = &hardware::PaperBench();
  report.calibration_refusal = "the stretch is too short";
  PdfReader pdf(Pdf(report));
  const std::string text = pdf.Text();
  EXPECT_EQ(pdf.Pages(), 1);
  EXPECT_THAT(text, HasSubstr(Squeezed("none: the stretch is too short")));
  EXPECT_THAT(text, HasSubstr(Squeezed("uploaded recording")));
  EXPECT_THAT(text, HasSubstr(Squeezed("No verdict")));
}

}  // namespace
}  // namespace faultlab::server

#include "server/report/report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "hardware/bench/benches.h"
#include "server/plots/figures.h"
#include "server/report/path_outcome.h"
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
  report.excitation = "prbs: low 2 V, high 3 V";
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
  verdict.path = {{"a1 outside its band?", true, 0.1063, 0.01452, "b0"},
                  {"a1 and b0 in opposite directions?", true, 0.1063, 0.0, "R1"}};
  verdict.settled = true;
  report.diagnosis.calibration.emplace();
  report.diagnosis.calibration->dated = "2026-11-20";
  report.diagnosis.calibration->delta_s = 9.542e-3;
  report.diagnosis.calibration->um_noise_v = 15.5e-3;
  report.estimates = {{"SWA, K = 100", {{"b0d", 2.23, 0.2516, 0.2532}, {"b1d", -1.1, {}, {}}}}};
  report.modelled = core::Fault{.component = Part("R1"), .value = 100.0};
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
  for (const char* said : {"Ogled 3: čšćžđ, Покус, R1",
                           "Mila Antić (mila)",
                           "2026-11-21 01:02:03 UTC",
                           "sim-1",
                           "prbs: low 2 V, high 3 V",
                           "2000, every 10 ms: 20 s",
                           "of 2026-11-20, stored with the rig",
                           "9.542 ms",
                           "um 15.5 mV",
                           "Fault: R1",
                           "100.2 Ω ± 110 mΩ (standard error); nominal 1 Ω",
                           "C8 = 3.741 mF, with a residual of 71.5 times",
                           "at 10.02 s, by residual; the change began at about 9.99 s",
                           "Decision path of the paper’s method",
                           "a1 outside its band? yes (0.1063, limit 0.01452) → b0",
                           "The path ends at R1, as the verdict does.",
                           "10.00 1000 R1 100 Ω confirmed",
                           "12.00 1200 Ra 9 Ω refused",
                           "b0d SWA, K = 100 2.23 0.2516 −88.7 0.2532",
                           "b1d SWA, K = 100 −1.1 – – –",
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

TEST(Report, SpeaksSerbian) {
  const std::string text = PdfReader(Pdf(Sample(), Language::kSerbian)).Text();
  for (const char* said : {"Izveštaj o ogledu",
                           "Uređaj sim-1",
                           "Otkaz: R1",
                           "standardna greška",
                           "Put odlučivanja po metodi iz rada",
                           "potvrđeno"}) {
    EXPECT_THAT(text, HasSubstr(Squeezed(said)));
  }
  EXPECT_THAT(text, Not(HasSubstr("Verdict")));
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
  EXPECT_EQ(ComparePath(verdict, *report.bench), PathOutcome::kWindow);
  EXPECT_THAT(PdfReader(Pdf(report)).Text(1),
              HasSubstr(Squeezed("The path ends at R12 or C8; the verdict is different: Fault: R1. "
                                 "The path uses the estimates of one window")));
  verdict.path.front().threshold = 0.09;
  EXPECT_EQ(ComparePath(verdict, *report.bench), PathOutcome::kClose);
  EXPECT_THAT(PdfReader(Pdf(report)).Text(1),
              HasSubstr(Squeezed("The step “a1 outside its band?” was decided by a number close")));
  verdict.settled = false;
  EXPECT_EQ(ComparePath(verdict, *report.bench), PathOutcome::kSettling);
  verdict.kind = core::VerdictKind::kUnknownFault;
  EXPECT_EQ(ComparePath(verdict, *report.bench), PathOutcome::kUnknown);
  verdict.kind = core::VerdictKind::kNominal;
  EXPECT_EQ(ComparePath(verdict, *report.bench), PathOutcome::kNothing);
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

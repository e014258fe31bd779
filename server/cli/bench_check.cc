#include "server/cli/bench_check.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <vector>

#include "core/calibration/calibrate.h"
#include "core/diagnosis/diagnosis_options.h"
#include "core/isolability/expected_error.h"
#include "core/plant/simulate_record.h"
#include "core/signals/excitation.h"
#include "core/types/check.h"
#include "core/types/number_text.h"
#include "core/types/time_span.h"
#include "hardware/bench/benches.h"
#include "hardware/relay_board.h"
#include "hardware/run_forecast.h"
#include "server/cli/console.h"
#include "server/diagnosis_json/isolability_json.h"
#include "server/diagnosis_json/isolability_question.h"

namespace faultlab::server {
namespace {

using core::Bench;

constexpr std::size_t kWindowSamples = 100;
constexpr double kLongWindowS = 10.0;
constexpr double kUsualRunS = 20.0;

template <typename... Numbers>
std::string Format(const char* format, Numbers... numbers) {
  return core::Format(format, numbers...);
}

std::string Padded(std::string text, std::size_t width) {
  text.resize(std::max(text.size() + 1, width), ' ');
  return text;
}

std::string ChannelsOf(const Bench& bench) {
  std::string channels;
  const auto add = [&channels](const core::BenchChannel& channel, const char* name) {
    if (channel.exists) channels += (channels.empty() ? "" : ", ") + std::string(name);
  };
  add(bench.um, "um");
  add(bench.ua, "ua");
  add(bench.ia, "ia");
  add(bench.n, "n");
  return channels;
}

std::string HeadOf(const Bench& bench) {
  std::string out =
      bench.name + ": " + bench.title + "\n" + "structure " + std::string(bench.structure->name) +
      Format(", a sample every %g ms, channels ", 1e3 * bench.period_s) + ChannelsOf(bench) + "\n";
  for (const core::Component component : bench.components()) {
    const core::ComponentInfo& info = component.info();
    out += "  " + info.symbol + Format(" = %g ", info.nominal) + info.unit + ", " +
           (info.positions.empty() ? "changed by simulators only"
                                   : std::to_string(info.positions.size()) + " relay positions") +
           "\n";
  }
  if (!bench.limits_stated) out += "  No [limits]: a rig of this class can only be simulated.\n";
  if (!bench.um.exists) {
    const core::BenchNorm& norm = bench.norm;
    const double one_of_many = 1.0 / std::hypot(1.0 / norm.gain, 1.0 / norm.ra, 1.0 / norm.ke);
    out +=
        "  No voltage is measured: the data tell the gain, Ra, Ke, J, B and friction up to one\n"
        "  common factor. Values carry the tolerances of the data sheet, about " +
        Format("%g %%.\n", std::round(1e3 * one_of_many) / 10.0);
  }
  return out;
}

/// Relays that a rig of this class switches have to settle before the sample is read.
std::optional<std::string> RelayNote(const Bench& bench) {
  const bool switched =
      std::ranges::any_of(bench.parts, [](const auto& part) { return !part.positions.empty(); });
  const hardware::RelayTiming usual;
  const auto milliseconds = [](hardware::Nanoseconds span) {
    return std::chrono::duration<double, std::milli>(span).count();
  };
  const double delta_ms = 1e3 * bench.delta_s;
  const bool enough = milliseconds(usual.gap + usual.settle) < delta_ms;
  if (enough || !switched || !bench.limits_stated) return std::nullopt;
  return Format(
      "relays: gap_ms + settle_ms of the rig file must be below delta_s = %g ms; it has to state "
      "them, since %g + %g ms are usual",
      delta_ms,
      milliseconds(usual.gap),
      milliseconds(usual.settle));
}

/// What a healthy stretch of the usual run lacks for learning the rig.
std::optional<std::string> NotLearned(const Bench& bench, std::span<const double> uc_v) {
  const core::DiagnosisOptions usual = core::OptionsOf(bench);
  const std::vector<core::Sample> record =
      core::SimulateRecord(bench.profiles.front(), bench.nominal, uc_v, {}, 1, bench.period_s);
  const auto sample = [&](double t_s) {
    const auto at = static_cast<std::size_t>(std::lround(t_s / bench.period_s));
    return record.begin() + static_cast<std::ptrdiff_t>(std::min(at, record.size()));
  };
  core::CalibrationOptions options{.bench = &bench, .data_sheet = bench.nominal};
  options.period_s = bench.period_s;
  options.um_rail_v = usual.um_rail_v;
  const auto learned =
      core::Calibrate({sample(usual.healthy_from_s), sample(usual.healthy_to_s)}, options);
  if (learned) return std::nullopt;
  return Format("from %g to %g s a healthy rig is ", usual.healthy_from_s, usual.healthy_to_s) +
         learned.error().message;
}

/// What an input that reverses the motor needs of the counter.
std::optional<std::string> TurnsBack(const hardware::RunForecast& forecast) {
  constexpr double kShare = 0.02;
  for (const hardware::SignalForecast& signal : forecast.signals) {
    if (signal.name != "n" || !signal.in_use) continue;
    const double back = std::min(-signal.reaches.min, signal.reaches.max);
    const double most = std::max(-signal.reaches.min, signal.reaches.max);
    if (back <= kShare * most) return std::nullopt;
    return Format("n goes from %.4g to %.4g rpm: ", signal.reaches.min, signal.reaches.max) +
           "simulators read the direction, the drivers of real rigs count pulses without it";
  }
  return std::nullopt;
}

/// A speed from the times of an encoder's pulses is the mean of the last interval; one from their
/// count is known to the parts of a pulse at either end.
std::optional<std::string> SlowPulses(const Bench& bench, const hardware::RunForecast& forecast) {
  constexpr double kEnough = 50.0;
  if (bench.n.step_s <= 0.0 && !bench.reads_means()) return std::nullopt;
  for (const hardware::SignalForecast& signal : forecast.signals) {
    if (signal.name != "n" || !signal.in_use) continue;
    // Half of the fastest where the motor passes through rest, else the middle.
    const double fastest = std::max(-signal.reaches.min, signal.reaches.max);
    const double middle = 0.5 * std::abs(signal.reaches.min + signal.reaches.max);
    const double rpm = bench.reverses() ? 0.5 * fastest : middle;
    const double pulses = rpm / 60.0 * bench.nominal.gear_ratio * bench.pulses_per_revolution;
    if (pulses * bench.period_s >= kEnough) return std::nullopt;
    const std::string few =
        Format("n: %.3g pulses of the encoder in a period at ", pulses * bench.period_s);
    if (bench.reads_means()) {
      return few + Format("%.4g rpm: a count is off by up to one, which hides small faults", rpm);
    }
    return few +
           Format("%.4g rpm: the speed is the mean of the last interval, which the models do not ",
                  rpm) +
           Format("know; with fewer than %g faults may be called unknown and values be off",
                  kEnough);
  }
  return std::nullopt;
}

std::string SignalTable(const hardware::RunForecast& forecast) {
  const auto band = [](const hardware::SignalSpan& span, const std::string& unit) {
    const auto end = [](double value) {
      return std::isfinite(value) ? Format("%.4g", value) : std::string("..");
    };
    return end(span.min) + " to " + end(span.max) + " " + unit;
  };
  std::string out;
  for (const hardware::SignalForecast& signal : forecast.signals) {
    const bool ends = std::isfinite(signal.may.min) || std::isfinite(signal.may.max);
    std::string bounds = ends ? signal.bounded_by + (" " + band(signal.may, signal.unit)) : "";
    if (!signal.in_use) bounds = "not measured";
    const std::string reaches = band(signal.reaches, signal.unit);
    out += "  " + Padded(signal.name, 8) +
           (bounds.empty() ? reaches : Padded(reaches, 26) + bounds) + "\n";
  }
  return out;
}

/// The usual run on healthy and on faulty rigs.
struct UsualRun {
  std::string text;
  int problems = 0;
};

UsualRun PlayUsualRun(const Bench& bench, std::span<const double> uc_v) {
  const hardware::RunForecast healthy = hardware::ForecastRun(bench, uc_v);
  std::vector<hardware::RunProblem> problems = healthy.problems;
  if (const auto missing = NotLearned(bench, uc_v)) problems.push_back({"learning", *missing});
  UsualRun run;
  run.problems = static_cast<int>(problems.size());
  run.text = "\nThe usual run: " + Format("%g s of ", kUsualRunS) + bench.excitation_text +
             ", a healthy rig\n" + SignalTable(healthy);
  for (const hardware::RunProblem& problem : problems) {
    run.text += "PROBLEM: " + problem.text + "\n";
  }
  if (const auto turns = TurnsBack(healthy)) run.text += "note: " + *turns + "\n";
  if (const auto slow = SlowPulses(bench, healthy)) run.text += "note: " + *slow + "\n";
  if (const auto note = RelayNote(bench)) run.text += "note: " + *note + "\n";
  for (const core::FaultSize& fault : core::FaultsOf(bench)) {
    const auto faulty = hardware::ForecastRun(
        bench, uc_v, core::Fault{.component = fault.component, .value = fault.value});
    for (const hardware::RunProblem& problem : faulty.problems) {
      const bool of_all = std::ranges::any_of(
          problems, [&](const auto& each) { return each.about == problem.about; });
      if (of_all) continue;
      run.text += "note: with " + std::string(core::Name(fault.component)) +
                  Format(" = %g ", fault.value) + std::string(core::Unit(fault.component)) + " " +
                  problem.text + "\n";
    }
  }
  return run;
}

core::Result<core::IsolabilityOptions> QuestionOf(const Bench& bench,
                                                  const BenchCheckOptions& options) {
  IsolabilityQuestion question;
  question.bench = &bench;
  question.channels = options.channels;
  question.window_samples = static_cast<int>(core::SpanOf(kWindowSamples, bench.period_s));
  question.excitation = bench.excitation;
  question.excitation_name = bench.excitation_text;
  return ToOptions(question);
}

/// Errors of the values after the window of the question and after a long one.
std::string ErrorTable(const core::IsolabilityOptions& question) {
  const Bench& bench = *question.bench;
  const core::DiagnosisOptions usual = core::OptionsOf(bench);
  const double healthy_s = usual.healthy_to_s - usual.healthy_from_s;
  std::vector<int> windows = {question.window_samples};
  const int longer = static_cast<int>(std::lround(kLongWindowS / bench.period_s));
  if (longer > windows.front()) windows.push_back(longer);
  core::IsolabilityOptions asked = question;
  asked.window_samples = windows.back();
  const double duration_s = healthy_s + windows.back() * bench.period_s;
  asked.uc_v = core::Generate(bench.excitation, duration_s, bench.period_s).value();
  std::string out =
      Format("\nExpected error: one standard deviation, the rig learned from %g healthy s\n",
             healthy_s) +
      Padded("Value", 27);
  for (const int window : windows) out += Padded(Format("after %g s", window * bench.period_s), 14);
  out.erase(out.find_last_not_of(' ') + 1);
  out += "\n";
  for (const core::ExpectedError& error :
       core::ExpectedErrors(asked, core::TolerancesOf(bench), windows)) {
    out += Padded(std::string(core::Name(error.fault.component)) +
                      Format(" = %.6g ", error.fault.value) +
                      std::string(core::Unit(error.fault.component)),
                  27);
    for (const double sigma : error.relative_sigma) {
      // An error of a whole factor is no estimate.
      out += Padded(sigma < 1.0 ? Format("%.3g %%", 1e2 * sigma) : "none", 14);
    }
    out.erase(out.find_last_not_of(' ') + 1);
    out += "\n";
  }
  return out;
}

}  // namespace

int RunBenchCheck(const BenchCheckOptions& options) {
  TRY_INPUT(const auto read, hardware::LoadBench(options.bench));
  const Bench& bench = *read;
  const auto uc_v = core::Generate(bench.excitation, kUsualRunS, bench.period_s);
  LAB_CHECK(uc_v.ok());  // the reader has tried it
  const core::Result<core::IsolabilityOptions> question = QuestionOf(bench, options);
  if (!question) {
    core::Error error = question.error();
    if (error.field == "excitation") error.message = options.bench + ": bench." + error.message;
    return Fail(error, kExitBadInput);
  }
  TRY_INPUT(const auto judged, core::AnalyseIsolability(question.value()));
  const UsualRun run = PlayUsualRun(bench, uc_v.value());
  std::string out = HeadOf(bench) + run.text;
  if (core::FaultsOf(bench).empty()) {
    out +=
        "\nnote: no component has `values` or `offered`: which faults can be confused, and the "
        "errors of their values, are not told\n";
  }
  out += "\nWhat the first " + Format("%g", question.value().window_samples * bench.period_s) +
         " s of a fault show under " + bench.excitation_text + ":\n" + ToText(judged) +
         ErrorTable(question.value());
  if (const int printed = Print(out); printed != kExitOk) return printed;
  if (run.problems == 0) return kExitOk;
  PrintError(options.bench + ": " + std::to_string(run.problems) +
             (run.problems == 1 ? " problem" : " problems") +
             " of the usual run, marked PROBLEM above");
  return kExitFailure;
}

}  // namespace faultlab::server

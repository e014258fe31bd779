#include "server/cli/diagnose.h"

#include <boost/json/array.hpp>
#include <boost/json/serialize.hpp>
#include <filesystem>
#include <utility>

#include "core/diagnosis/diagnose_record.h"
#include "core/types/number_text.h"
#include "core/types/utf8.h"
#include "hardware/bench/benches.h"
#include "server/cli/calibration_file.h"
#include "server/cli/console.h"
#include "server/cli/methods.h"
#include "server/cli/recording_source.h"
#include "server/csv/bench_comment.h"
#include "server/csv/csv_record.h"
#include "server/diagnosis_json/calibration_json.h"
#include "server/diagnosis_json/channels_text.h"
#include "server/diagnosis_json/diagnosis_json.h"
#include "server/json/list_of.h"
#include "server/methods/method_run_json.h"
#include "server/plots/record_figure.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using core::Error;
using core::ErrorCode;
using core::Result;

json::object DiagnosisJsonOf(const std::string& file,
                             const CsvRecord& record,
                             const core::Diagnosis& diagnosis,
                             const core::Bench& bench) {
  json::object out = {{"file", core::IsUtf8(file) ? file : core::FromWindows1252(file)},
                      {"samples", record.samples.size()},
                      {"period_s", record.period_s},
                      {"channels", ListOf(record.channels)},
                      {"notes", ListOf(record.notes)}};
  json::object rest = ToJson(diagnosis, bench);
  for (json::key_value_pair& member : rest) {
    out.emplace(member.key(), std::move(member.value()));
  }
  return out;
}

/// Replaces each folder by the recordings in it, sorted by name.
Result<std::vector<std::string>> WithFolders(const std::vector<std::string>& names) {
  std::vector<std::string> files;
  for (const std::string& name : names) {
    std::error_code error;
    if (!std::filesystem::is_directory(name, error)) {
      files.push_back(name);
      continue;
    }
    TRY(const auto inside, RecordingsIn(name));
    files.insert(files.end(), inside.begin(), inside.end());
  }
  return files;
}

/// "FROM:TO" into the stretch that is taken as fault-free.
core::Status ReadHealthy(const std::string& text, core::DiagnosisOptions& options) {
  const std::size_t colon = text.find(':');
  const std::optional<double> from = core::ParseNumber(text.substr(0, colon));
  const std::optional<double> to =
      colon == std::string::npos ? std::nullopt : core::ParseNumber(text.substr(colon + 1));
  if (!from || !to || *from < 0.0 || *to <= *from) {
    return Error{
        ErrorCode::kInvalid,
        "--healthy '" + text + "': expected FROM:TO in seconds, 0 <= FROM < TO, for example 0.5:5",
        "healthy"};
  }
  options.healthy_from_s = *from;
  options.healthy_to_s = *to;
  return core::Done{};
}

}  // namespace

Result<core::DiagnosisOptions> ParseFlags(const DiagnosisFlags& flags, const core::Bench& bench) {
  const auto refuse = [](const std::string& message, const std::string& field) {
    return Error{ErrorCode::kInvalid, message, field};
  };
  core::DiagnosisOptions options = core::OptionsOf(bench);
  if (!flags.healthy.empty()) {
    if (const core::Status read = ReadHealthy(flags.healthy, options); !read) return read.error();
  }
  const auto channels = ParseChannels(flags.channels, bench);
  if (!channels) return refuse("--" + channels.error().message, "channels");
  options.channels = channels.value();
  if (flags.values != "table2" && flags.values != "none") {
    return refuse("--values '" + flags.values + "': expected table2 or none", "values");
  }
  if (!flags.calibration.empty()) {
    TRY(options.calibration, ReadCalibrationFile(flags.calibration, bench));
  }
  options.values = flags.values == "table2" ? core::ValuePrior::kTable2 : core::ValuePrior::kNone;
  return options;
}

void FollowRecord(const DiagnosisFlags& flags,
                  std::span<const core::Sample> samples,
                  double period_s,
                  core::DiagnosisOptions& options) {
  options.period_s = period_s;
  if (!flags.healthy.empty()) return;
  const core::DiagnosisOptions usual = core::OptionsOf(*options.bench, period_s);
  options.healthy_from_s = usual.healthy_from_s;
  options.healthy_to_s = usual.healthy_to_s;
  if (!samples.empty()) core::CountFrom(samples.front().t_s, options);
}

namespace {

/// One method of the literature on one record.
Result<std::string> DiagnoseByMethod(const core::MethodInfo& method,
                                     const std::string& file,
                                     const CsvRecord& record,
                                     const core::DiagnosisOptions& diagnose,
                                     bool as_json) {
  core::MethodOptions options = core::MethodOptionsOf(*diagnose.bench, record.period_s);
  options.healthy_from_s = diagnose.healthy_from_s;
  options.healthy_to_s = diagnose.healthy_to_s;
  TRY(const auto task, core::PrepareMethods(record.samples, options));
  const core::MethodRun run = core::RunMethod(method, task, record.samples, options.healthy_to_s);
  if (!as_json) return ToText(run, file);
  json::object out = {{"file", file}};
  json::object found = ToJson(run);
  for (json::key_value_pair& member : found) out.emplace(member.key(), std::move(member.value()));
  return json::serialize(out) + "\n";
}

}  // namespace

int RunDiagnose(const DiagnoseCommandOptions& options) {
  TRY_INPUT(const auto bench, hardware::LoadBench(options.flags.bench));
  TRY_INPUT(auto parsed, ParseFlags(options.flags, *bench));
  const core::MethodInfo* method = core::FindMethod(options.method);
  if (!options.method.empty()) {
    TRY_INPUT_DONE(CheckMethod(options.method, *bench));
  }
  int exit_code = kExitOk;
  TRY_INPUT(const auto files, WithFolders(options.files));
  for (const std::string& file : files) {
    const Result<CsvRecord> record = ReadCsv(file);
    if (!record) {
      exit_code = Fail(record.error(), kExitBadInput);
      continue;
    }
    if (const core::Status fits = CheckPeriod(parsed.calibration, record.value().period_s); !fits) {
      PrintError(file + ": " + fits.error().message);
      exit_code = kExitBadInput;
      continue;
    }
    PrintNotes(record.value().notes);
    NoteOtherBench(file, BenchInComments(record.value().comments), options.flags.bench, *bench);
    core::DiagnosisOptions diagnose = parsed;
    const auto notes =
        NotesOnRecord(record.value().channels, record.value().samples, *diagnose.bench, file);
    if (!notes) {
      PrintError(notes.error().message);
      exit_code = kExitBadInput;
      continue;
    }
    PrintNotes(notes.value());
    FollowRecord(options.flags, record.value().samples, record.value().period_s, diagnose);
    if (method != nullptr) {
      const Result<std::string> said =
          DiagnoseByMethod(*method, file, record.value(), diagnose, options.json);
      if (!said) {
        PrintError(file + ": " + said.error().message);
        exit_code = kExitBadInput;
      } else if (Print(said.value()) != kExitOk) {
        return kExitFailure;
      }
      continue;
    }
    core::Diagnosis diagnosis = core::DiagnoseRecord(record.value().samples, diagnose);
    core::SuggestBench(record.value().samples, diagnose, hardware::LoadShippedBenches(), diagnosis);
    AddModelFits(record.value().samples, diagnose, diagnosis);
    std::string questions;
    for (const std::string& each : record.value().questions) {
      questions += "  question    " + each + "\n";
    }
    const std::string text =
        options.json
            ? json::serialize(DiagnosisJsonOf(file, record.value(), diagnosis, *diagnose.bench)) +
                  "\n"
            : ToText(diagnosis, file) + questions;
    if (Print(text) != kExitOk) {
      return kExitFailure;
    }
  }
  return exit_code;
}

}  // namespace faultlab::server

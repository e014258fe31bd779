#include "server/cli/methods.h"

#include <unistd.h>

#include <boost/json/parse.hpp>
#include <boost/json/serialize.hpp>
#include <cstdio>
#include <filesystem>
#include <map>
#include <optional>
#include <utility>

#include "hardware/bench/benches.h"
#include "server/cli/console.h"
#include "server/cli/figure_file.h"
#include "server/cli/recording_source.h"
#include "server/csv/csv_record.h"
#include "server/csv/fault_text.h"
#include "server/csv/file_io.h"
#include "server/diagnosis_json/channels_text.h"
#include "server/methods/method_report.h"
#include "server/methods/method_study.h"

namespace faultlab::server {
namespace {

namespace fs = std::filesystem;
namespace json = boost::json;
using core::Error;
using core::ErrorCode;
using core::Result;

constexpr std::size_t kManifestBytesMax = std::size_t{4} << 20;
constexpr std::size_t kMarkdownBytesMax = std::size_t{4} << 20;

/// One of {"component": "R1", "value": 10, "at_s": 10}; none for a part that the bench does not
/// list.
std::optional<core::Fault> FaultOf(const json::value& entry, const core::Bench& bench) {
  boost::system::error_code ignored;
  const json::value* component = entry.find_pointer("/component", ignored);
  const json::value* value = entry.find_pointer("/value", ignored);
  const json::value* at_s = entry.find_pointer("/at_s", ignored);
  const bool complete = component != nullptr && component->is_string() && value != nullptr &&
                        value->is_number() && at_s != nullptr && at_s->is_number();
  if (!complete) return std::nullopt;
  const auto found = bench.Find(std::string_view(component->get_string()));
  if (!found) return std::nullopt;
  core::Fault fault;
  fault.component = *found;
  fault.value = value->to_number<double>();
  fault.at_s = at_s->to_number<double>();
  return fault;
}

/// The injected faults by file, of a manifest.json beside the recordings:
///   {"recordings": [{"file": "..", "faults": [{"component": "R1", "value": 10, "at_s": 10}]}]}
/// None for a file with a fault that this bench cannot have.
using FaultsByFile = std::map<std::string, std::optional<std::vector<core::Fault>>>;

FaultsByFile FaultsInManifest(const fs::path& folder, const core::Bench& bench) {
  FaultsByFile faults;
  const Result<std::string> text = ReadFile((folder / "manifest.json").string(), kManifestBytesMax);
  if (!text) return faults;
  boost::system::error_code error;
  const json::value root = json::parse(text.value(), error);
  const json::value* list = error ? nullptr : root.find_pointer("/recordings", error);
  if (list == nullptr || !list->is_array()) return faults;
  for (const json::value& entry : list->get_array()) {
    boost::system::error_code ignored;
    const json::value* file = entry.find_pointer("/file", ignored);
    const json::value* injected = entry.find_pointer("/faults", ignored);
    if (file == nullptr || !file->is_string() || injected == nullptr || !injected->is_array()) {
      continue;
    }
    std::optional<std::vector<core::Fault>>& of_file =
        faults.try_emplace(std::string(file->get_string()), std::in_place).first->second;
    for (const json::value& each : injected->get_array()) {
      const std::optional<core::Fault> fault = FaultOf(each, bench);
      if (!fault) {
        of_file.reset();
        break;
      }
      of_file->push_back(*fault);
    }
  }
  return faults;
}

Result<std::vector<MethodRecord>> ReadRecordings(const std::string& folder,
                                                 const core::Bench& bench) {
  TRY(const auto files, RecordingsIn(folder));
  const auto manifest = FaultsInManifest(folder, bench);
  std::vector<MethodRecord> records;
  for (const std::string& file : files) {
    TRY(auto read, ReadCsv(file));
    MethodRecord record;
    record.name = fs::path(file).filename().string();
    record.samples = std::move(read.samples);
    record.period_s = read.period_s;
    record.faults = FaultsInComments(read.comments, bench);
    const auto noted = manifest.find(record.name);
    if (record.faults.empty() && noted != manifest.end()) {
      if (!noted->second) continue;  // it is not healthy, and no method could be right
      record.faults = *noted->second;
    }
    // Methods of the literature know abrupt faults, one at a time.
    if (record.faults.size() > 1) continue;
    records.push_back(std::move(record));
  }
  return records;
}

core::Status Write(const MethodsCommandOptions& options, const MethodStudy& study) {
  if (!options.markdown.empty()) {
    std::string text = MarkdownTitle();
    if (options.append) {
      TRY(auto before, ReadFile(options.markdown, kMarkdownBytesMax));
      text = std::move(before) + "\n";
    }
    TRY_DONE(WriteFile(options.markdown, text + ToMarkdown(study)));
  }
  if (options.plots_dir.empty()) return core::Done{};
  if (study.faults.empty()) {
    return Error{ErrorCode::kInvalid,
                 "--plots draws methods and faults; none of these recordings names its fault",
                 "plots"};
  }
  std::error_code error;
  fs::create_directories(options.plots_dir, error);
  return WriteFigure(
      MakeMethodFigure(study), (fs::path(options.plots_dir) / "methods.png").string(), 1);
}

}  // namespace

core::Status CheckMethod(const std::string& name, const core::Bench& bench) {
  const core::MethodInfo* method = core::FindMethod(name);
  if (method == nullptr) {
    std::string known;
    for (const core::MethodInfo& info : core::AllMethods()) known += " " + std::string(info.name);
    return Error{ErrorCode::kInvalid, "--method '" + name + "': expected one of" + known, "method"};
  }
  if (!core::Fits(*method, bench)) {
    return Error{ErrorCode::kInvalid,
                 "--method '" + name + "' was made for another bench than " + bench.name,
                 "method"};
  }
  return core::Done{};
}

int RunMethods(const MethodsCommandOptions& options) {
  TRY_INPUT(const auto bench, hardware::LoadBench(options.bench));
  MethodStudyOptions study_options;
  study_options.bench = bench;
  if (!options.channels.empty()) {
    const auto channels = ParseChannels(options.channels, *bench);
    if (!channels) {
      return Fail({channels.error().code, "--" + channels.error().message, "channels"},
                  kExitBadInput);
    }
    study_options.channels = channels.value();
  }
  study_options.methods = options.methods;
  study_options.trials = options.trials;
  study_options.healthy_hours = options.hours;
  study_options.seed = options.seed;
  for (const std::string& name : options.methods) {
    TRY_INPUT_DONE(CheckMethod(name, *bench));
  }
  if (options.trials < 1 || !(options.hours >= 0.0)) {
    return Fail({ErrorCode::kInvalid, "--trials at least 1, --hours at least 0", "trials"},
                kExitBadInput);
  }
  const auto progress = [shown = -1, watched = isatty(STDERR_FILENO) != 0](double done) mutable {
    if (!watched) return true;
    const int percent = static_cast<int>(100.0 * done);
    if (percent != shown) std::fprintf(stderr, "\r%3d %%%s", percent, percent == 100 ? "\n" : "");
    shown = percent;
    return true;
  };
  MethodStudy study;
  if (options.recordings.empty()) {
    study = StudyMethods(study_options, progress);
  } else {
    TRY_INPUT(const auto records, ReadRecordings(options.recordings, *bench));
    study = StudyRecordings(study_options, records, progress);
  }
  if (const int ended = Ended(Write(options, study)); ended != kExitOk) return ended;
  return Print(options.json ? json::serialize(ToJson(study)) + "\n" : ToText(study));
}

}  // namespace faultlab::server

#include "server/cli/recording_source.h"

#include <algorithm>
#include <filesystem>

#include "hardware/bench/benches.h"
#include "server/csv/bench_comment.h"
#include "server/csv/csv_record.h"
#include "server/csv/fault_text.h"
#include "server/experiment/benches.h"
#include "server/experiment/plan_json.h"
#include "server/storage/database.h"
#include "server/storage/recording_store.h"

namespace faultlab::server {
namespace {

using core::Error;
using core::ErrorCode;
using core::Result;

bool IsCsvName(const std::string& name) {
  std::error_code ignored;
  return name.ends_with(".csv") || name.ends_with(".csv.gz") || name == "-" ||
         std::filesystem::exists(name, ignored);
}

Result<SourceRecording> FromCsv(const std::string& path, const core::Bench& bench) {
  TRY(auto read, ReadCsv(path));
  SourceRecording out;
  out.name = std::filesystem::path(path).filename().string();
  out.bench = &bench;
  out.bench_named = BenchInComments(read.comments);
  out.faults = FaultsInComments(read.comments, bench);
  out.period_s = read.period_s;
  out.notes = std::move(read.notes);
  out.samples = std::move(read.samples);
  return out;
}

Result<SourceRecording> FromStore(const std::string& id, const std::string& data_dir) {
  const std::filesystem::path file = std::filesystem::path(data_dir) / "faultlab.db";
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) {
    return Error{ErrorCode::kNotFound,
                 "'" + id + "' is no CSV file, and there is no database of runs at " +
                     file.string() + "; name a file or the folder with --data",
                 "recording"};
  }
  TRY(auto database, Database::Open({.location = file.string()}));
  RecordingStore store(*database);
  TRY(auto record, store.Get(id));
  TRY(auto samples, store.LoadSamples(id));
  SourceRecording out;
  out.name = record.name.empty() ? id : record.name;
  out.period_s = record.period_s;
  TRY(const auto bench, Benches(*database, {&hardware::PaperBench()}).OfRecording(record.bench));
  out.bench = bench;
  out.faults = FaultsOfPlan(record.plan_json, *bench);
  out.samples = std::move(samples);
  return out;
}

}  // namespace

Result<std::vector<std::string>> RecordingsIn(const std::string& folder) {
  namespace fs = std::filesystem;
  std::vector<std::string> files;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error); !error && entry != fs::directory_iterator();
       entry.increment(error)) {
    const std::string path = entry->path().string();
    if (path.ends_with(".csv") || path.ends_with(".csv.gz")) files.push_back(path);
  }
  if (error || files.empty()) {
    return Error{ErrorCode::kNotFound,
                 error ? "cannot read the folder " + folder + ": " + error.message()
                       : "no .csv or .csv.gz in the folder " + folder,
                 "folder"};
  }
  std::ranges::sort(files);
  return files;
}

Result<SourceRecording> LoadRecording(const std::string& recording,
                                      const std::string& data_dir,
                                      const core::Bench& bench) {
  return IsCsvName(recording) ? FromCsv(recording, bench) : FromStore(recording, data_dir);
}

}  // namespace faultlab::server

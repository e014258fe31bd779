#include "server/cli/recording_source.h"

#include <boost/json/parse.hpp>
#include <filesystem>
#include <limits>
#include <string_view>

#include "server/csv/csv_record.h"
#include "server/csv/fault_text.h"
#include "server/storage/database.h"
#include "server/storage/recording_store.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using core::Error;
using core::ErrorCode;
using core::Result;

bool IsCsvName(const std::string& name) {
  std::error_code ignored;
  return name.ends_with(".csv") || name.ends_with(".csv.gz") || name == "-" ||
         std::filesystem::exists(name, ignored);
}

/// The schedule of a stored plan; a plan without one has none.
std::vector<core::Fault> FaultsOfPlan(const std::string& plan_json) {
  std::vector<core::Fault> faults;
  boost::system::error_code error;
  const json::value plan = json::parse(plan_json, error);
  const json::object* object = error ? nullptr : plan.if_object();
  const json::value* list = object == nullptr ? nullptr : object->if_contains("faults");
  if (list == nullptr || !list->is_array()) {
    return faults;
  }
  for (const json::value& entry : list->get_array()) {
    const json::object* one = entry.if_object();
    if (one == nullptr) {
      continue;
    }
    const auto number = [one](std::string_view key) {
      const json::value* value = one->if_contains(key);
      return value != nullptr && value->is_number() ? value->to_number<double>() : 0.0;
    };
    const auto text = [one](std::string_view key) {
      const json::value* value = one->if_contains(key);
      return value != nullptr && value->is_string() ? std::string(value->get_string())
                                                    : std::string();
    };
    const std::optional<core::Component> component = core::ParseComponent(text("component"));
    if (!component) {
      continue;
    }
    const std::string kind = text("kind");
    faults.push_back({*component,
                      number("value"),
                      number("at_s"),
                      kind == "drift"          ? core::FaultKind::kDrift
                      : kind == "intermittent" ? core::FaultKind::kIntermittent
                                               : core::FaultKind::kAbrupt,
                      number("until_s")});
  }
  return faults;
}

Result<SourceRecording> FromCsv(const std::string& path) {
  Result<CsvRecord> record = ReadCsv(path);
  if (!record) {
    return record.error();
  }
  CsvRecord& read = record.value();
  SourceRecording out;
  out.name = std::filesystem::path(path).filename().string();
  out.faults = FaultsInComments(read.comments);
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
  Result<std::unique_ptr<Database>> database = Database::Open({.location = file.string()});
  if (!database) {
    return database.error();
  }
  RecordingStore store(*database.value());
  Result<RunRecord> record = store.Get(id);
  if (!record) {
    return record.error();
  }
  Result<std::vector<core::Sample>> samples =
      store.LoadSamples(id, 0, std::numeric_limits<std::int64_t>::max());
  if (!samples) {
    return samples.error();
  }
  SourceRecording out;
  out.name = record.value().name.empty() ? id : record.value().name;
  out.period_s = record.value().period_s;
  out.faults = FaultsOfPlan(record.value().plan_json);
  out.samples = std::move(samples).value();
  return out;
}

}  // namespace

Result<SourceRecording> LoadRecording(const std::string& recording, const std::string& data_dir) {
  return IsCsvName(recording) ? FromCsv(recording) : FromStore(recording, data_dir);
}

}  // namespace faultlab::server

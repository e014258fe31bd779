#include "server/cli/diagnose.h"

#include <boost/json/array.hpp>
#include <boost/json/serialize.hpp>
#include <utility>

#include "server/cli/console.h"
#include "server/csv/csv_record.h"
#include "server/csv/number_text.h"
#include "server/diagnosis_json/diagnosis_json.h"
#include "server/plots/record_figure.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using core::Error;
using core::ErrorCode;
using core::Result;

json::object JsonOf(const std::string& file,
                    const CsvRecord& record,
                    const core::Diagnosis& diagnosis) {
  json::array channels;
  for (const std::string& channel : record.channels) {
    channels.emplace_back(channel);
  }
  json::object out = {{"file", file},
                      {"samples", record.samples.size()},
                      {"period_s", record.period_s},
                      {"channels", std::move(channels)}};
  json::object rest = ToJson(diagnosis);
  for (json::key_value_pair& member : rest) {
    out.emplace(member.key(), std::move(member.value()));
  }
  return out;
}

}  // namespace

Result<core::DiagnoseOptions> ParseFlags(const DiagnosisFlags& flags) {
  const auto refuse = [](const std::string& message, const std::string& field) {
    return Error{ErrorCode::kInvalid, message, field};
  };
  core::DiagnoseOptions options;
  const std::size_t colon = flags.healthy.find(':');
  const std::optional<double> from = ParseNumber(flags.healthy.substr(0, colon));
  const std::optional<double> to =
      colon == std::string::npos ? std::nullopt : ParseNumber(flags.healthy.substr(colon + 1));
  if (!from || !to || *from < 0.0 || *to <= *from) {
    return refuse("--healthy '" + flags.healthy +
                      "': expected FROM:TO in seconds, 0 <= FROM < TO, for example 0.5:5",
                  "healthy");
  }
  options.healthy_from_s = *from;
  options.healthy_to_s = *to;
  if (flags.channels != "um" && flags.channels != "all") {
    return refuse("--channels '" + flags.channels + "': expected um or all", "channels");
  }
  options.channels = flags.channels == "um" ? core::Channels::kUmOnly : core::Channels::kAll;
  if (flags.values != "table2" && flags.values != "none") {
    return refuse("--values '" + flags.values + "': expected table2 or none", "values");
  }
  options.values = flags.values == "table2" ? core::ValuePrior::kTable2 : core::ValuePrior::kNone;
  return options;
}

int RunDiagnose(const DiagnoseCommandOptions& options) {
  Result<core::DiagnoseOptions> parsed = ParseFlags(options.flags);
  if (!parsed) {
    return Fail(parsed.error(), kExitBadInput);
  }
  int exit_code = kExitOk;
  for (const std::string& file : options.files) {
    const Result<CsvRecord> record = ReadCsv(file);
    if (!record) {
      exit_code = Fail(record.error(), kExitBadInput);
      continue;
    }
    for (const std::string& note : record.value().notes) {
      PrintError("note: " + note);
    }
    core::DiagnoseOptions diagnose = parsed.value();
    diagnose.period_s = record.value().period_s;
    core::Diagnosis diagnosis = core::DiagnoseRecord(record.value().samples, diagnose);
    AddModelFits(record.value().samples, diagnose, diagnosis);
    const std::string text = options.json
                                 ? json::serialize(JsonOf(file, record.value(), diagnosis)) + "\n"
                                 : ToText(diagnosis, file);
    if (Print(text) != kExitOk) {
      return kExitFailure;
    }
  }
  return exit_code;
}

}  // namespace faultlab::server

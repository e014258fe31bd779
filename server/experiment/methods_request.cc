#include "server/experiment/methods_request.h"

#include <algorithm>
#include <boost/json.hpp>

#include "core/methods/method_session.h"
#include "server/experiment/diagnosis_request.h"
#include "server/json/json_reader.h"
#include "server/methods/method_run_json.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

constexpr std::size_t kNamesMax = 100;

core::Result<const core::MethodInfo*> MethodOf(const json::value& name, std::size_t at) {
  const std::string field = "/methods/names/" + std::to_string(at);
  const core::MethodInfo* info =
      name.is_string() ? core::FindMethod(std::string_view(name.get_string())) : nullptr;
  if (info != nullptr) return info;
  std::string known;
  for (const core::MethodInfo& each : core::AllMethods()) {
    known.append(known.empty() ? "" : ", ").append(each.name);
  }
  return core::Refuse("word_unknown", field, {{"member", field}, {"words", known}});
}

/// Those of the request that are to be tried on this bench.
core::Result<std::vector<const core::MethodInfo*>> MethodsFor(const MethodsRequest& request,
                                                              const core::Bench& bench) {
  std::vector<const core::MethodInfo*> methods = request.methods;
  for (const core::MethodInfo* each : methods) {
    if (core::Fits(*each, bench)) continue;
    return core::Refuse(
        "method_of_other_bench", "/methods/names", {{"method", each->name}, {"bench", bench.name}});
  }
  if (!methods.empty()) return methods;
  for (const core::MethodInfo& each : core::AllMethods()) {
    if (core::Fits(each, bench)) methods.push_back(&each);
  }
  return methods;
}

/// What an earlier part of the work has done, as far as it is the same work: the program may have
/// been replaced in between.
json::array StillAsked(json::array done, const std::vector<const core::MethodInfo*>& methods) {
  std::size_t same = 0;
  while (same < std::min(done.size(), methods.size()) &&
         done[same].at("method").as_string() == methods[same]->name) {
    ++same;
  }
  done.resize(same);
  return done;
}

core::MethodOptions MethodOptionsFor(const MethodsRequest& request,
                                     const core::Bench& bench,
                                     double period_s) {
  core::MethodOptions options = core::MethodOptionsOf(bench, period_s);
  options.channels = request.channels;
  options.healthy_from_s = request.healthy_from_s.value_or(options.healthy_from_s);
  options.healthy_to_s = request.healthy_to_s.value_or(options.healthy_to_s);
  return options;
}

}  // namespace

core::Result<MethodsRequest> ParseMethodsRequest(const json::object& body) {
  ObjectReader in(body, "");
  const json::object* wanted = in.ObjectOrNull("methods");
  (void)in.TextOr("name", "", kRecordingIdBytesMax);
  if (auto error = in.Finish()) return *error;
  if (wanted == nullptr) {
    return core::Refuse("member_missing", "/methods", {{"member", "methods"}});
  }
  ObjectReader settings(*wanted, "/methods");
  MethodsRequest request;
  request.recording = settings.Text("recording", kRecordingIdBytesMax);
  request.channels = settings.WordOr("channels", "um", {"um", "all"}) == "all"
                         ? core::Channels::kAll
                         : core::Channels::kUmOnly;
  if (settings.Has("healthy_from_s"))
    request.healthy_from_s = settings.NumberOr("healthy_from_s", 0.0, 0.0, kRecordingSecondsMax);
  if (settings.Has("healthy_to_s"))
    request.healthy_to_s = settings.NumberOr("healthy_to_s", 0.0, 0.0, kRecordingSecondsMax);
  const json::array* names = settings.ArrayOrNull("names", kNamesMax);
  if (auto error = settings.Finish()) return *error;
  for (std::size_t i = 0; names != nullptr && i < names->size(); ++i) {
    TRY(const auto method, MethodOf((*names)[i], i));
    request.methods.push_back(method);
  }
  return request;
}

core::Status CheckMethods(Recordings& recordings,
                          const Principal& who,
                          const MethodsRequest& request) {
  TRY(const auto record,
      FinishedRecording(recordings, who, request.recording, "/methods/recording"));
  TRY(const auto stored, recordings.OptionsFor(record));
  const auto methods = MethodsFor(request, *stored.bench);
  return methods.ok() ? core::Status(core::Done{}) : methods.error();
}

core::Result<std::string> CompareMethods(
    Recordings& recordings,
    const Principal& who,
    const MethodsRequest& request,
    const std::string& so_far,
    const std::function<core::Status(const std::string& so_far, bool is_long)>& keep) {
  TRY(auto record, FinishedRecording(recordings, who, request.recording, "/methods/recording"));
  TRY(const auto recording,
      recordings.Load(std::move(record), 0, kSampleIndexMax, LongTurn::For::kJob));
  const core::Bench& bench = *recording.options.bench;
  const double period_s = recording.record.period_s;
  TRY(const auto methods, MethodsFor(request, bench));
  const core::MethodOptions options = MethodOptionsFor(request, bench, period_s);
  TRY(const auto task, core::PrepareMethods(recording.samples, options));
  json::object out{{"recording", request.recording},
                   {"bench", bench.id},
                   {"samples", recording.samples.size()},
                   {"period_s", period_s},
                   {"healthy_to_s", options.healthy_to_s},
                   {"of", methods.size()},
                   {"methods", json::array()}};
  json::array& done = out["methods"].as_array();
  if (!so_far.empty()) done = StillAsked(json::parse(so_far).at("methods").as_array(), methods);
  const bool is_long = recording.turn != nullptr;
  for (std::size_t i = done.size(); i < methods.size(); ++i) {
    done.push_back(
        ToJson(core::RunMethod(*methods[i], task, recording.samples, options.healthy_to_s)));
    TRY_DONE(keep(json::serialize(out), is_long));
  }
  return json::serialize(out);
}

}  // namespace faultlab::server

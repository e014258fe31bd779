// Pictures of the bench: now, while a run goes on, and those that are stored with its recording.
#include <algorithm>
#include <boost/json.hpp>
#include <chrono>

#include "server/api/run/handlers.h"
#include "server/experiment/plan_json.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

/// The same answer whether there is no camera, the run has ended or its faults are hidden.
core::Error NoCamera() {
  return core::Refuse("no_picture");
}

/// The run as it is now, if its rig may be looked at by all who see the run.
std::optional<RunSnapshot> OnItsRig(Api& api, const RunRecord& run) {
  if (run.state != RunState::kRunning || HidesFaults(run.plan_json)) return std::nullopt;
  auto live = api.runs.Find(run.id);
  if (!live || live->state != RunState::kRunning || !live->on_rig) return std::nullopt;
  return live;
}

core::Result<HttpResponse> GetCamera(Api& api, const ApiRequest& request) {
  const auto before = OnItsRig(api, request.run);
  if (!before || !api.cameras.Has(before->rig)) return NoCamera();
  // Not a picture of the run before, whose faults this viewer may not know.
  TRY(const auto picture, api.cameras.Look(before->rig, before->began));
  // The rig may have gone to another run meanwhile.
  if (!OnItsRig(api, request.run)) return NoCamera();
  const auto age =
      std::chrono::duration_cast<std::chrono::milliseconds>(api.clock.Monotonic() - picture->asked);
  HttpResponse response;
  response.content_type = picture->content_type;
  response.headers.emplace_back("X-Picture-Age-Ms", std::to_string(age.count()));
  response.headers.emplace_back("Cache-Control", "no-store");
  response.body = picture->bytes;
  return response;
}

core::Result<HttpResponse> ListPictures(Api& api, const ApiRequest& request) {
  json::array items;
  if (!HidesFaults(request.run.plan_json)) {
    TRY(const auto pictures, api.pictures.List(request.run.id));
    items = ListOf(pictures, [&](const StoredPicture& picture) {
      return json::object{{"index", picture.index},
                          {"sample", picture.sample},
                          {"t_s", static_cast<double>(picture.sample) * request.run.period_s},
                          {"why", picture.why},
                          {"content_type", picture.content_type},
                          {"size_bytes", picture.size_bytes}};
    });
  }
  return JsonResponse(json::object{{"items", std::move(items)}});
}

core::Result<HttpResponse> GetPicture(Api& api, const ApiRequest& request) {
  TRY(const auto index, PathNumber(request, "index"));
  const core::Error missing = core::Refuse("no_picture");
  if (HidesFaults(request.run.plan_json) || index > PictureStore::kOfRunMax) {
    return missing;
  }
  auto bytes = api.pictures.Load(request.run.id, static_cast<int>(index));
  if (!bytes) {
    return bytes.error().code == core::ErrorCode::kNotFound ? missing : bytes.error();
  }
  const std::string_view type = PictureType(bytes.value());
  auto spool = api.MakeSpool();
  spool->Append(bytes.value());
  return Spooled(std::move(spool), type);
}

}  // namespace

bool HasCamera(Api& api, const RunRecord& run) {
  return api.cameras.Has(run.rig) && OnItsRig(api, run).has_value();
}

std::span<const ApiRoute> PicturesRoutes() {
  using namespace routing;
  static constexpr auto kRoutes = std::to_array<ApiRoute>({
      {kGet, "runs/{id}/camera", kReadRun, kRun, GetCamera, kNoBody, kOutside, kRunsMember},
      {kGet, "runs/{id}/pictures", kReadRun, kRun, ListPictures},
      {kGet, "runs/{id}/pictures/{index}", kReadRun, kRun, GetPicture},
  });
  return kRoutes;
}

}  // namespace faultlab::server

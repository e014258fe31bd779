#include "server/api/run/handlers.h"

namespace faultlab::server {

std::vector<ApiRoute> RoutesOf(RunApi& api) {
  using enum HttpMethod;
  using enum Operation;
  using enum Guard;
  using enum AnswerSize;
  using enum LivesAt;
  const auto on = [&api](auto handler) { return On(api, handler); };
  return {
      {kPost, "/api/v1/runs", kStartRun, kRole, on(CreateRun), kJson, kSmall, kBodysRig},
      {kGet, "/api/v1/runs", kReadRun, kObject, on(ListRuns)},
      {kGet, "/api/v1/runs/{id}", kReadRun, kRun, on(GetRun), kNoBody, kSmall, kRunsMember},
      {kDelete, "/api/v1/runs/{id}", kDeleteRun, kRun, on(DeleteRun)},
      {kPost, "/api/v1/runs/{id}/stop", kChangeRun, kRun, on(StopRun), kEmpty, kSmall, kRunsMember},
      {kPost,
       "/api/v1/runs/{id}/stream-token",
       kReadRun,
       kRun,
       on(IssueStreamToken),
       kEmpty,
       kSmall,
       kRunsViewers},
      {kGet,
       "/api/v1/runs/{id}/events",
       kReadRun,
       kRun,
       on(ListEvents),
       kNoBody,
       kSmall,
       kRunsMember},
      {kGet, "/api/v1/runs/{id}/frames", kReadRun, kRun, on(GetFrames), kNoBody, kLarge},
      {kGet, "/api/v1/runs/{id}/samples", kReadRun, kRun, on(GetSamples), kNoBody, kLarge},
      {kGet, "/api/v1/runs/{id}/estimates", kReadRun, kRun, on(GetEstimates), kNoBody, kLarge},
      {kGet,
       "/api/v1/runs/{id}/diagnosis",
       kReadRun,
       kRun,
       on(GetDiagnosis),
       kNoBody,
       kSmall,
       kRunsMember},
      {kGet, "/api/v1/runs/{id}/export.csv", kReadRun, kRun, on(ExportCsv), kNoBody, kLarge},
      {kGet, "/api/v1/runs/{id}/export.mat", kReadRun, kRun, on(ExportMat), kNoBody, kLarge},
      {kGet, "/api/v1/runs/{id}/export.json", kReadRun, kRun, on(ExportJson), kNoBody, kLarge},
      {kGet, "/api/v1/runs/{id}/plots/{figure}.png", kReadRun, kRun, on(GetPlot)},
      {kGet, "/api/v1/runs/{id}/figures/{figure}", kReadRun, kRun, on(GetFigure)},
      {kPost, "/api/v1/recordings", kUploadRecording, kRole, on(UploadRecording), kUpload},
      {kGet, "/api/v1/recordings", kReadRun, kObject, on(ListRecordings)},
  };
}

}  // namespace faultlab::server

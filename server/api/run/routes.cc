#include "server/api/run/handlers.h"

namespace faultlab::server {

std::vector<ApiRoute> RoutesOf(RunApi& api) {
  using enum HttpMethod;
  using enum Operation;
  using enum Guard;
  using enum Cost;
  using enum LivesAt;
  const auto on = [&api](auto handler) { return On(api, handler); };
  return {
      {kPost, "/api/v1/runs", kStartRun, kRole, on(CreateRun), kJson, kQuick, kBodysRig},
      {kGet, "/api/v1/runs", kReadRun, kObject, on(ListRuns)},
      {kGet, "/api/v1/runs/{id}", kReadRun, kRun, on(GetRun), kNoBody, kQuick, kRunsMember},
      {kPatch, "/api/v1/runs/{id}", kReadRun, kRun, on(DescribeRun), kJson},
      {kDelete, "/api/v1/runs/{id}", kDeleteRun, kRun, on(DeleteRun)},
      {kPost, "/api/v1/runs/{id}/stop", kChangeRun, kRun, on(StopRun), kEmpty, kQuick, kRunsMember},
      {kPost,
       "/api/v1/runs/{id}/calibration",
       kChangeRun,
       kRun,
       on(LearnAgain),
       kEmpty,
       kQuick,
       kRunsMember},
      {kPost,
       "/api/v1/runs/{id}/stream-token",
       kReadRun,
       kRun,
       on(IssueStreamToken),
       kEmpty,
       kQuick,
       kRunsViewers},
      {kGet,
       "/api/v1/runs/{id}/events",
       kReadRun,
       kRun,
       on(ListEvents),
       kNoBody,
       kQuick,
       kRunsMember},
      {kGet, "/api/v1/runs/{id}/frames", kReadRun, kRun, on(GetFrames), kNoBody, kTransfer},
      {kGet, "/api/v1/runs/{id}/samples", kReadRun, kRun, on(GetSamples), kNoBody, kTransfer},
      {kGet, "/api/v1/runs/{id}/estimates", kReadRun, kRun, on(GetEstimates), kNoBody, kTransfer},
      {kGet,
       "/api/v1/runs/{id}/diagnosis",
       kReadRun,
       kRun,
       on(GetDiagnosis),
       kNoBody,
       kQuick,
       kRunsMember},
      {kGet, "/api/v1/runs/{id}/export.csv", kReadRun, kRun, on(ExportCsv), kNoBody, kTransfer},
      {kGet, "/api/v1/runs/{id}/export.mat", kReadRun, kRun, on(ExportMat), kNoBody, kTransfer},
      {kGet, "/api/v1/runs/{id}/export.lcm", kReadRun, kRun, on(ExportLcmLog), kNoBody, kTransfer},
      {kGet, "/api/v1/runs/{id}/export.json", kReadRun, kRun, on(ExportJson), kNoBody, kTransfer},
      {kGet, "/api/v1/runs/{id}/report.pdf", kReadRun, kRun, on(GetReport), kNoBody, kTransfer},
      {kGet, "/api/v1/runs/{id}/plots/{figure}.png", kReadRun, kRun, on(GetPlot), kNoBody, kHeavy},
      {kGet, "/api/v1/runs/{id}/figures/{figure}", kReadRun, kRun, on(GetFigure), kNoBody, kHeavy},
      {kGet,
       "/api/v1/runs/{id}/camera",
       kReadRun,
       kRun,
       on(GetCamera),
       kNoBody,
       kOutside,
       kRunsMember},
      {kGet, "/api/v1/runs/{id}/pictures", kReadRun, kRun, on(ListPictures)},
      {kGet, "/api/v1/runs/{id}/pictures/{index}", kReadRun, kRun, on(GetPicture)},
      {kPost,
       "/api/v1/recordings",
       kUploadRecording,
       kRole,
       on(UploadRecording),
       kUpload,
       kTransfer},
      {kGet, "/api/v1/comparison.png", kReadRun, kObject, on(GetComparison), kNoBody, kHeavy},
      {kGet, "/api/v1/usage", kReadRun, kObject, on(GetUsage)},
      {kGet, "/api/v1/recordings", kReadRun, kObject, on(ListRecordings)},
  };
}

}  // namespace faultlab::server

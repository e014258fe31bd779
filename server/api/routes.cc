#include "server/api/handlers.h"

namespace faultlab::server {

std::vector<ApiRoute> ExperimentRoutes() {
  using enum HttpMethod;
  using enum Operation;
  using enum Guard;
  using enum AnswerSize;
  return {
      {kGet, "/healthz", kReadPublic, kOpen, Healthz},
      {kGet, "/readyz", kReadPublic, kRole, Readyz},
      {kGet, "/metrics", kReadPublic, kRole, Metrics},
      {kGet, "/api/v1/openapi.json", kReadPublic, kOpen, OpenApi},
      {kGet, "/api/v1/auth/me", kReadPublic, kRole, Me},
      {kGet, "/api/v1/benches", kReadPublic, kOpen, ListBenches},
      {kGet, "/api/v1/benches/{bench}/model", kReadPublic, kOpen, GetBenchModel},
      {kGet, "/api/v1/rigs", kListRigs, kRole, ListRigs},
      {kGet, "/api/v1/rigs/{id}/calibrations", kListRigs, kRole, ListRigCalibrations},

      {kPost, "/api/v1/runs", kStartRun, kRole, CreateRun, kJson},
      {kGet, "/api/v1/runs", kReadRun, kObject, ListRuns},
      {kGet, "/api/v1/runs/{id}", kReadRun, kObject, GetRun},
      {kDelete, "/api/v1/runs/{id}", kDeleteRun, kObject, DeleteRun},
      {kPost, "/api/v1/runs/{id}/stop", kChangeRun, kObject, StopRun, kJson},
      {kPost, "/api/v1/runs/{id}/stream-token", kReadRun, kObject, IssueStreamToken, kJson},
      {kGet, "/api/v1/runs/{id}/events", kReadRun, kObject, ListEvents},
      {kGet, "/api/v1/runs/{id}/frames", kReadRun, kObject, GetFrames, kNoBody, kLarge},
      {kGet, "/api/v1/runs/{id}/samples", kReadRun, kObject, GetSamples, kNoBody, kLarge},
      {kGet, "/api/v1/runs/{id}/estimates", kReadRun, kObject, GetEstimates, kNoBody, kLarge},
      {kGet, "/api/v1/runs/{id}/diagnosis", kReadRun, kObject, GetDiagnosis},
      {kGet, "/api/v1/runs/{id}/export.csv", kReadRun, kObject, ExportCsv, kNoBody, kLarge},
      {kGet, "/api/v1/runs/{id}/export.mat", kReadRun, kObject, ExportMat, kNoBody, kLarge},
      {kGet, "/api/v1/runs/{id}/export.json", kReadRun, kObject, ExportJson, kNoBody, kLarge},
      {kGet, "/api/v1/runs/{id}/plots/{figure}.png", kReadRun, kObject, GetPlot},
      {kGet, "/api/v1/runs/{id}/figures/{figure}", kReadRun, kObject, GetFigure},

      {kPost, "/api/v1/recordings", kUploadRecording, kRole, UploadRecording, kUpload},
      {kGet, "/api/v1/recordings", kReadRun, kObject, ListRecordings},
  };
}

}  // namespace faultlab::server

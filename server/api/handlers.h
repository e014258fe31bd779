#pragma once

#include "server/api/api.h"

// The endpoints of an experiment, one function each; routes.cc says where they hang.
namespace faultlab::server {

// system_api.cc
core::Result<HttpResponse> Healthz(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> Readyz(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> Metrics(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> OpenApi(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> Me(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> ListRigs(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> ListRigCalibrations(ApiContext& api, const ApiRequest& request);

// bench_api.cc
core::Result<HttpResponse> ListBenches(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> GetBenchModel(ApiContext& api, const ApiRequest& request);

// run_api.cc
core::Result<HttpResponse> CreateRun(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> ListRuns(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> GetRun(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> StopRun(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> DeleteRun(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> IssueStreamToken(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> ListEvents(ApiContext& api, const ApiRequest& request);

// data_api.cc
core::Result<HttpResponse> GetFrames(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> GetSamples(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> GetEstimates(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> GetDiagnosis(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> ExportCsv(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> ExportMat(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> ExportJson(ApiContext& api, const ApiRequest& request);

// figure_api.cc
core::Result<HttpResponse> GetPlot(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> GetFigure(ApiContext& api, const ApiRequest& request);

// recording_api.cc
core::Result<HttpResponse> UploadRecording(ApiContext& api, const ApiRequest& request);
core::Result<HttpResponse> ListRecordings(ApiContext& api, const ApiRequest& request);

}  // namespace faultlab::server

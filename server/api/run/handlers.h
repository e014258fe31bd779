#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "server/api/gate.h"
#include "server/auth/accounts.h"
#include "server/auth/audit_log.h"
#include "server/camera/camera_reader.h"
#include "server/experiment/experiments.h"
#include "server/run/run_manager.h"
#include "server/storage/picture_store.h"

// Runs and uploads: starting, watching, their data, figures and exports.
namespace faultlab::server {

struct RunApi {
  Experiments& experiments;
  Recordings& recordings;
  RunManager& runs;
  RecordingStore& store;
  RigAccess& rigs;
  Accounts& accounts;
  StreamTokens& tokens;
  StorageQuota& quota;
  Benches& benches;
  RunQuota& places;
  AuditLog& audit;
  DiskReserve spool_disk;
  CameraReader& cameras;
  PictureStore& pictures;
  const Clock& clock;
  std::string public_url;  ///< "https://lab.example.org"; empty: not known

  /// For an answer that may be large.
  std::unique_ptr<Spool> MakeSpool() const { return std::make_unique<Spool>(spool_disk); }
};

std::vector<ApiRoute> RoutesOf(RunApi& api);

// runs.cc
/// Those of a list that may be opened by now.
void OpenDue(RunApi& api, std::vector<RunRecord>& records);
/// A line of the audit log; of guests only so many.
void NoteOnRun(RunApi& api, const AuditNote& note);
core::Result<HttpResponse> CreateRun(RunApi& api, const ApiRequest& request);
core::Result<HttpResponse> ListRuns(RunApi& api, const ApiRequest& request);
core::Result<HttpResponse> GetRun(RunApi& api, const ApiRequest& request);
core::Result<HttpResponse> DescribeRun(RunApi& api, const ApiRequest& request);
core::Result<HttpResponse> StopRun(RunApi& api, const ApiRequest& request);
core::Result<HttpResponse> LearnAgain(RunApi& api, const ApiRequest& request);
core::Result<HttpResponse> DeleteRun(RunApi& api, const ApiRequest& request);
core::Result<HttpResponse> IssueStreamToken(RunApi& api, const ApiRequest& request);
core::Result<HttpResponse> ListEvents(RunApi& api, const ApiRequest& request);

// data.cc
core::Result<HttpResponse> GetFrames(RunApi& api, const ApiRequest& request);
core::Result<HttpResponse> GetSamples(RunApi& api, const ApiRequest& request);
core::Result<HttpResponse> GetEstimates(RunApi& api, const ApiRequest& request);
core::Result<HttpResponse> GetDiagnosis(RunApi& api, const ApiRequest& request);

/// The CSV of a recording, in pieces: what ExportCsv sends and whose SHA-256 the report states.
void FormatCsvOf(const Recording& recording,
                 std::span<const RecordedEvent> events,
                 const RunStory& story,
                 const std::function<void(std::string_view)>& take);

// exports.cc
core::Result<HttpResponse> ExportCsv(RunApi& api, const ApiRequest& request);
core::Result<HttpResponse> ExportMat(RunApi& api, const ApiRequest& request);
core::Result<HttpResponse> ExportLcmLog(RunApi& api, const ApiRequest& request);
core::Result<HttpResponse> ExportJson(RunApi& api, const ApiRequest& request);

// report.cc
core::Result<HttpResponse> GetReport(RunApi& api, const ApiRequest& request);

// figures.cc
core::Result<HttpResponse> GetPlot(RunApi& api, const ApiRequest& request);
core::Result<HttpResponse> GetFigure(RunApi& api, const ApiRequest& request);

// control.cc
core::Result<HttpResponse> GetControl(RunApi& api, const ApiRequest& request);

// comparison.cc
core::Result<HttpResponse> GetComparison(RunApi& api, const ApiRequest& request);

// pictures.cc
/// Whether GetCamera has a picture for those who see the run.
bool HasCamera(RunApi& api, const RunRecord& run);
core::Result<HttpResponse> GetCamera(RunApi& api, const ApiRequest& request);
core::Result<HttpResponse> ListPictures(RunApi& api, const ApiRequest& request);
core::Result<HttpResponse> GetPicture(RunApi& api, const ApiRequest& request);

// usage.cc
core::Result<HttpResponse> GetUsage(RunApi& api, const ApiRequest& request);

// uploads.cc
core::Result<HttpResponse> UploadRecording(RunApi& api, const ApiRequest& request);
core::Result<HttpResponse> ListRecordings(RunApi& api, const ApiRequest& request);
}  // namespace faultlab::server

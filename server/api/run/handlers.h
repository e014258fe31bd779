#pragma once

#include <functional>

#include "core/types/frame.h"
#include "server/api/api.h"

// Runs and uploads: starting, watching, their data, figures and exports.
namespace faultlab::server {

// runs.cc
/// Those of a list that may be opened by now.
void OpenDue(Api& api, std::vector<RunRecord>& records);
/// A line of the audit log; of guests only so many.
void NoteOnRun(Api& api, const AuditNote& note);

/// Of "estimator" in the query; without it the usual one.
core::Result<core::EstimatorId> EstimatorIn(const HttpRequest& request, core::EstimatorId usual);

/// The CSV of a recording, in pieces: what ExportCsv sends and whose SHA-256 the report states.
void FormatCsvOf(const Recording& recording,
                 std::span<const RecordedEvent> events,
                 const RunStory& story,
                 const std::function<void(std::string_view)>& take);

// pictures.cc
/// Whether GetCamera has a picture for those who see the run.
bool HasCamera(Api& api, const RunRecord& run);

}  // namespace faultlab::server

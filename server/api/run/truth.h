#pragma once

#include "core/types/result.h"
#include "server/api/gate.h"
#include "server/storage/recording_store.h"

namespace faultlab::server {

/// The run as a file shows it. A file leaves the server, so that of a run with hidden faults it
/// lacks what tells them (SealedPlan), unless the run's owner asks for `truth=include`.
core::Result<RunRecord> RunForFile(const ApiRequest& request);
/// The same of one of several runs in a file.
core::Result<RunRecord> RunForFile(const Principal& who, const HttpRequest& http, RunRecord run);

}  // namespace faultlab::server

#include "server/api/run/truth.h"

#include "server/api/request.h"
#include "server/experiment/plan_json.h"

namespace faultlab::server {

core::Result<RunRecord> RunForFile(const ApiRequest& request) {
  return RunForFile(request.who, request.http, request.run);
}

core::Result<RunRecord> RunForFile(const Principal& who, const HttpRequest& http, RunRecord run) {
  TRY(const auto asked, QueryWord(http, "truth", {"include"}));
  if (!HidesFaults(run.plan_json)) return run;
  if (!asked) {
    run.plan_json = SealedPlan(run.plan_json);
    return run;
  }
  if (run.owner == who.owner_key()) return run;
  return core::Error{core::ErrorCode::kForbidden,
                     "Only the owner of a run gets a file with its hidden faults.",
                     "truth",
                     "truth_of_another"};
}

}  // namespace faultlab::server

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
  return core::Refuse("truth_of_another", "truth");
}

}  // namespace faultlab::server

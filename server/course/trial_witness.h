#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string_view>
#include <vector>

#include "core/types/fault.h"
#include "server/clock.h"
#include "server/course/trials.h"
#include "server/run/run_manager.h"

namespace faultlab::server::course {

/// Stores what the rig confirmed of a trial when its run ends, or voids the trial: when the rig
/// failed ("rig_failed"), when its relays did not do what was drawn ("relay_mismatch"), and when
/// the run was cut by the server ("interrupted"), by somebody else ("stopped_by_another") or by the
/// end of a session that its student neither ended nor could foresee ("session_ended"). Whoever
/// stops the run, ends the session, hands it over or lets its time run out has used the attempt.
/// @param ended_by_user  whether this session was, in this sense; false when that is not known
std::shared_ptr<SealedWitness> MakeWitness(Trials trials,
                                           std::int64_t trial,
                                           std::vector<core::Fault> drawn,
                                           std::function<bool(lab::SessionId)> ended_by_user,
                                           const Clock& clock,
                                           std::function<void(std::string_view)> log);

}  // namespace faultlab::server::course

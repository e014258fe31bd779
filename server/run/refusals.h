#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/types/component.h"
#include "core/types/result.h"

// What people are refused when they run an experiment: each with a reason and parameters, so that a
// page can say it in its own language. The list stands in server/run/README.md.
namespace faultlab::server::refusal {

core::Error NoSimulator();
core::Error RigNeedsSession(const std::string& rig);
core::Error RigJustFound(const std::string& rig);
core::Error NoRig(const std::string& rig);
core::Error RigInUse(const std::string& rig);
/// The session has ended or was passed on.
core::Error TurnIsOver(const std::string& rig);
/// Its server does not answer.
core::Error RigAway(const std::string& rig);
core::Error RigElsewhere(const std::string& rig, const std::string& member);
core::Error RunsFull();
/// As many of one person as one person may have.
core::Error YourRunsFull(int runs_max);
core::Error YourSimulatorsFull(int simulators_max);
core::Error ReplayTooLong(double longest_s);
/// Of one owner; in samples.
core::Error QuotaFull(std::int64_t kept, std::int64_t most);
core::Error RunEnded();
core::Error StaleEpoch();
/// The server may have lost its rigs to another one: it was frozen, or the database is away.
core::Error OutOfTouch();
/// The run ends before it has learnt the healthy rig.
core::Error RunTooShort();
core::Error NotPositive(core::Component component);
core::Error NotSwitchable(const std::string& rig, core::Component component);
/// @param values  that its relays connect: "1, 10, 56, 100"
core::Error NotOfTheRelays(core::Component component, const std::string& values);
core::Error VoltageOutside(const std::string& rig, double lowest_v, double highest_v);
core::Error NoFaultSet();
core::Error EmptyRecording();

/// The refusal of a part: its field becomes `field`.
core::Error At(core::Error error, std::string field);

}  // namespace faultlab::server::refusal

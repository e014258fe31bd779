#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "core/bench/bench.h"
#include "core/types/component.h"
#include "core/types/result.h"
#include "hardware/lcm/rig_finder.h"

// The refusals for people who run an experiment, each with a reason and parameters, so that a page
// can show it in its own language. The list is in server/run/README.md.
namespace faultlab::server::refusal {

core::Error NoSimulator(const std::string& bench);
/// Something else is planned too soon on all of them.
core::Error SimulatorsPlanned();
/// All simulators are in use, and this caller waits for one.
/// @param again  when to ask again, to keep the place
core::Error InLine(std::size_t place, std::chrono::seconds wait, std::chrono::seconds again);
core::Error RigNeedsSession(const std::string& rig);
core::Error RigJustFound(const std::string& rig);
core::Error NoRig(const std::string& rig);
core::Error RigInUse(const std::string& rig);
/// The session has ended or was passed on to another user.
core::Error TurnIsOver(const std::string& rig);
/// The server of the rig does not answer.
core::Error RigAway(const std::string& rig);
core::Error RigElsewhere(const std::string& rig, const std::string& member);
/// Nobody can use the rig, which this server hears: RigRefusal is the reason.
core::Error RigRefused(const std::string& rig, const hardware::RemoteRigInfo& why);
/// The rig does not take the lease: the error of its Arm, with a reason: another lab has it, or
/// what the rig says is in its message alone.
core::Error OfLease(const std::string& rig, core::Error error);
/// The end of the run before is being read from the rig: RunRecovery.
core::Error RestAwaited(const std::string& rig);
core::Error RunsFull();
core::Error RunsOfGuestsFull();
/// This person has as many runs as one person may have.
core::Error YourRunsFull(int runs_max);
/// This caller begins runs faster than one may.
core::Error RunsTooFast(int wait_s);
core::Error YourSimulatorsFull(int simulators_max);
core::Error ReplayTooLong(double longest_s);
/// Recorded samples of one owner.
core::Error QuotaFull(std::int64_t kept, std::int64_t most);
core::Error RunEnded();
/// The run has ended, and its end is not stored yet: for a moment, or until the database is back.
core::Error EndNotStored();
core::Error StaleEpoch();
/// The server may have lost its rigs to another one: it was frozen, or the database is away.
core::Error OutOfTouch();
/// The run ends before the calibration of the healthy rig is complete.
core::Error RunTooShort();
/// Learning anew: a component is not nominal.
core::Error NotNominal(const std::string& component);
/// Learning anew: the plan changes a component in the stretch.
core::Error ChangePlanned(const std::string& component, double at_s);
/// Learning anew: a replay, a run with hidden faults, or under speed control.
core::Error LearnsOnce();
/// The run of a trial whose truth is not released.
core::Error RunSealed();
/// A fault set from which blind trials are drawn, which no run plays.
core::Error SetToDrawFrom();
/// @param symbol  that `bench` does not have
core::Error NoComponent(const core::Bench& bench, std::string_view symbol);
/// The rig is of another bench than what is asked of it.
core::Error OtherBench(const std::string& rig, const core::Bench& its, const std::string& asked);
/// An older description of this bench was given.
core::Error BenchHasChanged(const core::Bench& now);
core::Error NotPositive(core::Component component);
core::Error NotSwitchable(const std::string& rig, core::Component component);
/// @param values  the values that its relays can connect: "1, 10, 56, 100"
core::Error NotOfTheRelays(core::Component component, const std::string& values);
core::Error VoltageOutside(const std::string& rig, double lowest_v, double highest_v);
/// Its machine closes no loop.
core::Error NoSpeedControl(const std::string& rig);
/// The run ends before its rig can be learnt and controlled.
core::Error ControlAfterEnd(double from_s);
core::Error SpeedOutOfReach(double reachable_rad_s);
core::Error NoFaultSet();
core::Error FaultSetOfOtherBench(const std::string& its, const core::Bench& wanted);
core::Error EmptyRecording();
/// The stretch that is taken as fault-free ends before it begins.
core::Error StretchBackwards(std::string field);

/// The refusal for a part of a request: its field becomes `field`.
core::Error At(core::Error error, std::string field);
/// What a part of a request names is refused, so the request is invalid: as At, with kInvalid.
core::Error In(core::Error error, std::string field);

}  // namespace faultlab::server::refusal

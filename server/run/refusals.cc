#include "server/run/refusals.h"

#include <array>
#include <charconv>
#include <cmath>
#include <utility>

namespace faultlab::server::refusal {
namespace {

using core::Error;
using core::ErrorCode;

/// With as few digits as distinguish the value from its neighbours.
std::string Text(double value) {
  std::array<char, 32> text;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  return {text.data(), end};
}

std::string Symbol(core::Component component) {
  return std::string(core::Name(component));
}

}  // namespace

Error NoSimulator(const std::string& bench) {
  return {ErrorCode::kNotFound,
          "This server has no simulated rig of bench '" + bench +
              "'; name one of its other benches, or a rig.",
          "/bench",
          "no_simulator",
          {{"bench", bench}}};
}

Error SimulatorsPlanned() {
  return {ErrorCode::kBusy,
          "On every simulator something is planned before such a run has surely ended: ask for a "
          "shorter one.",
          "/rig",
          "simulators_planned"};
}

Error InLine(std::size_t place, std::chrono::seconds wait, std::chrono::seconds again) {
  const auto text = [](auto value) { return std::to_string(value); };
  return {
      ErrorCode::kBusy,
      "All simulators are in use. You are number " + text(place) + " in line, for about " +
          text(wait.count()) + " s: ask again every " + text(again.count()) +
          " s to keep the place.",
      "/rig",
      "in_line",
      {{"place", text(place)}, {"seconds", text(wait.count())}, {"again_s", text(again.count())}}};
}

Error RigNeedsSession(const std::string& rig) {
  return {ErrorCode::kForbidden,
          "This rig needs a session: ask for a place in its queue or book it.",
          "/rig",
          "rig_needs_session",
          {{"rig", rig}}};
}

Error RigJustFound(const std::string& rig) {
  return {ErrorCode::kUnavailable,
          "Rig '" + rig + "' has just been found and is not checked yet; try again in a minute.",
          "/rig",
          "rig_just_found",
          {{"rig", rig}}};
}

Error NoRig(const std::string& rig) {
  return {ErrorCode::kNotFound, "There is no rig '" + rig + "'.", "/rig", "no_rig", {{"rig", rig}}};
}

Error RigInUse(const std::string& rig) {
  return {ErrorCode::kBusy, "Rig '" + rig + "' is in use.", "/rig", "rig_in_use", {{"rig", rig}}};
}

Error TurnIsOver(const std::string& rig) {
  return {ErrorCode::kStale,
          "Your turn on rig '" + rig + "' is over.",
          "/rig",
          "turn_is_over",
          {{"rig", rig}}};
}

Error RigAway(const std::string& rig) {
  return {ErrorCode::kUnavailable,
          "The server of rig '" + rig + "' does not answer; try again in a few seconds.",
          "/rig",
          "rig_away",
          {{"rig", rig}}};
}

Error RigElsewhere(const std::string& rig, const std::string& member) {
  return {ErrorCode::kConflict,
          "Rig '" + rig + "' is moving to another server of this lab (" + member +
              "); try again in a few seconds.",
          "/rig",
          "rig_elsewhere",
          {{"rig", rig}, {"member", member}}};
}

Error RigRefused(const std::string& rig, const hardware::RemoteRigInfo& why) {
  return {ErrorCode::kUnavailable,
          "Rig '" + rig + "' cannot be used now: " + why.refusal_text + ".",
          "/rig",
          std::string(hardware::Name(*why.refusal)),
          {{"rig", rig}}};
}

Error OfLease(const std::string& rig, Error error) {
  const bool held = error.field == hardware::kLeaseField && error.code == ErrorCode::kBusy;
  if (!held && !error.reason.empty()) return error;
  error.reason =
      held ? std::string(hardware::Name(hardware::RigRefusal::kHeldElsewhere)) : "rig_refuses";
  error.parameters = {{"rig", rig}};
  return error;
}

Error RestAwaited(const std::string& rig) {
  return {ErrorCode::kUnavailable,
          "The end of the last run is still being read from rig '" + rig +
              "'; try again in a few seconds.",
          "/rig",
          "rest_awaited",
          {{"rig", rig}}};
}

Error RunsFull() {
  return {ErrorCode::kBusy, "As many runs as this server allows are running.", "", "runs_full"};
}

Error RunsOfGuestsFull() {
  return {ErrorCode::kBusy,
          "Guests use as many runs as they may together; sign in, or wait.",
          "",
          "runs_of_guests_full"};
}

Error YourRunsFull(int runs_max) {
  return {ErrorCode::kTooMany,
          "You have " + std::to_string(runs_max) +
              " runs in progress, as many as one person may have; stop one or wait.",
          "",
          "your_runs_full",
          {{"most", std::to_string(runs_max)}}};
}

Error RunsTooFast(int wait_s) {
  return {ErrorCode::kTooMany,
          "You begin runs faster than one may; wait " + std::to_string(wait_s) +
              " s, or send them together as jobs.",
          "",
          "runs_too_fast",
          {{"seconds", std::to_string(wait_s)}}};
}

Error YourSimulatorsFull(int simulators_max) {
  return {ErrorCode::kTooMany,
          "You use " + std::to_string(simulators_max) +
              " simulators, as many as one person may have; stop a run or wait.",
          "",
          "your_simulators_full",
          {{"most", std::to_string(simulators_max)}}};
}

Error ReplayTooLong(double longest_s) {
  return {ErrorCode::kTooLarge,
          "A recording of at most " + Text(longest_s) +
              " s can be replayed; its figures and estimates are there without a replay.",
          "/recording",
          "replay_too_long",
          {{"longest_s", Text(longest_s)}}};
}

Error QuotaFull(std::int64_t kept, std::int64_t most) {
  return {ErrorCode::kConflict,
          "Your recordings hold " + std::to_string(kept) + " samples of " + std::to_string(most) +
              "; delete some to make room.",
          "",
          "quota_full",
          {{"kept", std::to_string(kept)}, {"most", std::to_string(most)}}};
}

Error RunEnded() {
  return {ErrorCode::kConflict, "The run has ended.", "", "run_ended"};
}

Error EndNotStored() {
  return {ErrorCode::kConflict,
          "The run has ended, and its end is not stored yet; try again in a moment.",
          "",
          "end_not_stored"};
}

Error StaleEpoch() {
  return {ErrorCode::kStale,
          "The control of this rig has changed hands; reload the page.",
          "epoch",
          "stale_epoch"};
}

Error OutOfTouch() {
  return {ErrorCode::kUnavailable,
          "This server has lost touch with the lab; try again in a few seconds.",
          "",
          "out_of_touch"};
}

Error RunTooShort() {
  return {ErrorCode::kConflict,
          "This run ends before the healthy rig is learnt, so nothing can be changed in it: plan a "
          "longer one.",
          "",
          "run_too_short"};
}

Error NotPositive(core::Component component) {
  return {ErrorCode::kInvalid,
          Symbol(component) + " must be above 0 and at most 1e12, in the SI unit.",
          "value",
          "value_not_positive",
          {{"component", Symbol(component)}}};
}

Error NotNominal(const std::string& component) {
  return {ErrorCode::kConflict,
          component + " is not nominal: set all parts back to nominal, then learn the rig again.",
          "",
          "not_nominal",
          {{"component", component}}};
}

Error ChangePlanned(const std::string& component, double at_s) {
  return {ErrorCode::kConflict,
          "The plan changes " + component + " at " + Text(at_s) +
              " s, while the rig would be learnt; learn it again after that, at nominal.",
          "",
          "change_planned",
          {{"component", component}, {"at_s", Text(at_s)}}};
}

Error LearnsOnce() {
  return {ErrorCode::kConflict,
          "A replay, a run whose faults are hidden and one under speed control learn the rig only "
          "once.",
          "",
          "learns_once"};
}

Error RunSealed() {
  return {ErrorCode::kConflict,
          "This is the run of a blind trial: until its truth is released it is neither changed, "
          "diagnosed, replayed nor deleted by the lab.",
          "",
          "run_sealed"};
}

Error SetToDrawFrom() {
  return {ErrorCode::kInvalid,
          "Blind trials are drawn from this fault set: give it to an assignment.",
          "/fault_set",
          "set_to_draw_from"};
}

Error NoComponent(const core::Bench& bench, std::string_view symbol) {
  std::string known;
  for (const core::Component each : bench.components()) {
    known += (known.empty() ? "" : ", ") + Symbol(each);
  }
  const std::string shown(symbol);
  return {ErrorCode::kInvalid,
          "Unknown component '" + shown + "'; known: " + known + ".",
          "component",
          "no_component",
          {{"component", shown}, {"known", known}}};
}

Error OtherBench(const std::string& rig, const core::Bench& its, const std::string& asked) {
  return {ErrorCode::kInvalid,
          "Rig '" + rig + "' is of bench '" + its.name + "', not of '" + asked + "'.",
          "/bench",
          "other_bench",
          {{"rig", rig}, {"bench", its.name}, {"asked", asked}}};
}

Error FaultSetOfOtherBench(const std::string& its, const core::Bench& wanted) {
  return {ErrorCode::kInvalid,
          "This fault set is for bench '" + its + "'; the rig is of bench '" + wanted.name + "'.",
          "/fault_set",
          "fault_set_of_other_bench",
          {{"its", its}, {"bench", wanted.name}}};
}

Error BenchHasChanged(const core::Bench& now) {
  return {ErrorCode::kConflict,
          "The description of bench '" + now.name + "' has changed: it is " + now.id +
              " now. Check the faults against it and give this id.",
          "/bench",
          "bench_has_changed",
          {{"bench", now.name}, {"now", now.id}}};
}

Error NotSwitchable(const std::string& rig, core::Component component) {
  return {ErrorCode::kInvalid,
          "Rig '" + rig + "' cannot change " + Symbol(component) + ".",
          "component",
          "component_not_switchable",
          {{"rig", rig}, {"component", Symbol(component)}}};
}

Error NotOfTheRelays(core::Component component, const std::string& values) {
  return {ErrorCode::kInvalid,
          "The relay board of " + Symbol(component) + " has " + values + ".",
          "value",
          "value_not_of_the_relays",
          {{"component", Symbol(component)},
           {"values", values},
           {"unit", std::string(core::Unit(component))}}};
}

Error VoltageOutside(const std::string& rig, double lowest_v, double highest_v) {
  return {ErrorCode::kInvalid,
          "The control voltage of rig '" + rig + "' goes from " + Text(lowest_v) + " V to " +
              Text(highest_v) + " V.",
          "/excitation",
          "voltage_outside",
          {{"rig", rig}, {"lowest_v", Text(lowest_v)}, {"highest_v", Text(highest_v)}}};
}

Error NoSpeedControl(const std::string& rig) {
  return {ErrorCode::kInvalid,
          "Rig '" + rig + "' plays a plan: it cannot control its speed.",
          "/control",
          "no_speed_control",
          {{"rig", rig}}};
}

Error ControlAfterEnd(double from_s) {
  return {ErrorCode::kInvalid,
          "The speed is kept from " + Text(from_s) + " s on: plan a longer run.",
          "/duration_s",
          "control_after_end",
          {{"from_s", Text(from_s)}}};
}

Error SpeedOutOfReach(double reachable_rad_s) {
  return {ErrorCode::kInvalid,
          "This bench reaches " + Text(std::floor(reachable_rad_s)) + " rad/s.",
          "/control/reference/high_rad_s",
          "speed_out_of_reach",
          {{"reachable_rad_s", Text(std::floor(reachable_rad_s))}}};
}

Error NoFaultSet() {
  return {ErrorCode::kInvalid, "There is no such fault set for you.", "/fault_set", "no_fault_set"};
}

Error EmptyRecording() {
  return {ErrorCode::kInvalid, "The recording is empty.", "/recording", "empty_recording"};
}

Error StretchBackwards(std::string field) {
  return {ErrorCode::kInvalid,
          "The healthy stretch must end after it begins.",
          std::move(field),
          "stretch_backwards"};
}

Error At(Error error, std::string field) {
  error.field = std::move(field);
  return error;
}

Error In(Error error, std::string field) {
  error.code = ErrorCode::kInvalid;
  return At(std::move(error), std::move(field));
}

}  // namespace faultlab::server::refusal

// What a rig does at each tick of its run (paced_rig.h).
#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

#include "core/types/check.h"
#include "hardware/paced_rig.h"
#include "hardware/run_loop.h"

namespace faultlab::hardware {
namespace {

double Seconds(Nanoseconds time) {
  return std::chrono::duration<double>(time).count();
}

}  // namespace

/// Call with mutex_ held, when the machine has been made safe.
void PacedRig::NoteSafe(Nanoseconds cause_at) {
  if (!safe_after_) safe_after_ = options_.wall->Now() - cause_at;
}

void PacedRig::Latch(Trip trip) {
  if (!trip_) trip_ = std::move(trip);
}

void PacedRig::CountTick(const Wake& wake, std::vector<RigMessage>& out) {
  std::int64_t missed = 0;
  if (wake.lateness >= period_) {
    // The periods that have passed are not caught up in a rush: the grid moves on.
    missed = wake.lateness / period_;
    shift_ += missed * period_;
    ++consecutive_overruns_;
    out.emplace_back(RigEvent{.kind = RigEventKind::kOverrun,
                              .index = next_index_,
                              .value = Seconds(wake.lateness),
                              .text = "the tick came late"});
  } else {
    consecutive_overruns_ = 0;
  }
  const std::lock_guard lock(mutex_);
  quality_.lateness.Count(Seconds(wake.wall_lateness));
  quality_.missed_ticks += static_cast<std::uint64_t>(missed);
  if (wake.wall_lateness >= period_) ++quality_.overruns;
}

void PacedRig::CountActuation(const std::vector<RigMessage>& said) {
  const Nanoseconds now = options_.wall->Now();
  const std::lock_guard lock(mutex_);
  for (const RigMessage& message : said) {
    const auto* event = std::get_if<RigEvent>(&message);
    if (event == nullptr || event->kind != RigEventKind::kFaultCommanded) continue;
    if (event->text != kLiveText) continue;
    Nanoseconds& asked_at = asked_at_[static_cast<std::size_t>(core::Index(event->component))];
    if (asked_at == kNotAsked) continue;
    quality_.actuation.Count(Seconds(now - std::exchange(asked_at, kNotAsked)));
  }
}

PacedRig::Stop PacedRig::StopOfSilence() const {
  return {"watchdog: no word from the holder",
          Nanoseconds(heard_at_ns_.load(std::memory_order_relaxed))};
}

PacedRig::Stop PacedRig::FindStop() const {
  const Nanoseconds now = options_.wall->Now();
  {
    const std::lock_guard lock(mutex_);
    if (stop_reason_) return {*stop_reason_, now};
  }
  if (HolderIsSilent()) return StopOfSilence();
  if (consecutive_overruns_ >= options_.consecutive_overruns_max) {
    return {"overrun: " + std::to_string(consecutive_overruns_) + " ticks in a row came late", now};
  }
  return {"", now};
}

std::chrono::steady_clock::time_point PacedRig::ReaderDeadline() const {
  constexpr auto kForever = std::chrono::hours(24 * 365);
  return std::chrono::steady_clock::now() +
         (options_.watchdog.count() == 0 ? Nanoseconds(kForever) : options_.watchdog);
}

/// @returns no reason, or why the messages could not be handed on.
PacedRig::Stop PacedRig::Deliver(std::vector<RigMessage>& messages) {
  const auto stops = [this] { return stop_asked_.load(); };
  for (RigMessage& message : messages) {
    if (queue_.TryPush(std::move(message))) continue;
    // NOLINTBEGIN(bugprone-use-after-move): a message that is not taken is not moved from
    if (!options_.wait_for_reader) {
      return {"queue full: nobody reads the samples", options_.wall->Now()};
    }
    if (queue_.PushUntil(std::move(message), ReaderDeadline(), stops)) continue;
    if (!stop_asked_) return StopOfSilence();
    queue_.PushLast(std::move(message));
    // NOLINTEND(bugprone-use-after-move)
  }
  if (in_step_ && !messages.empty() && !queue_.WaitUntilRead(ReaderDeadline(), stops) &&
      !stop_asked_) {
    return StopOfSilence();
  }
  return {};
}

std::optional<Nanoseconds> PacedRig::Step(const Wake& wake) noexcept {
  const Nanoseconds tick_at = options_.wall->Now();
  Stop stop{"", tick_at};
  bool finished = false;
  messages_.clear();
  try {
    if (first_step_) {
      first_step_ = false;
      started_at_ = options_.clock->Now();
      messages_.emplace_back(RigEvent{.kind = RigEventKind::kStarted, .index = 0, .text = ""});
    } else {
      CountTick(wake, messages_);
    }
    stop = FindStop();
    if (stop.reason.empty()) {
      taken_.clear();
      std::optional<Nanoseconds> next;
      bool tripped = false;
      {
        const std::lock_guard machine_lock(machine_mutex_);
        // Asked again under the lock: a SafeStop that has made the rig safe must be the last word.
        if (!stop_asked_) {
          {
            const std::lock_guard lock(mutex_);
            taken_.swap(commands_);
          }
          const StepTime time{.planned = planned_,
                              .actual = options_.clock->Now() - started_at_,
                              .clock = options_.clock.get(),
                              .started_at = started_at_};
          next = machine_->Step(time, taken_, messages_);
          tripped = machine_->trip().has_value();
        } else {
          next = planned_;
        }
      }
      CountActuation(messages_);
      if (!messages_.empty()) {
        if (const auto* sample = std::get_if<core::Sample>(&messages_.back())) {
          next_index_ = sample->index + 1;
        }
      }
      if (Stop undelivered = Deliver(messages_); !undelivered.reason.empty()) {
        stop = std::move(undelivered);
      }
      if (stop.reason.empty() && !tripped && next) {
        planned_ = *next;
        const Nanoseconds due = started_at_ + planned_ + shift_;
        if (options_.heartbeat) options_.heartbeat->Beat(due - options_.clock->Now());
        return due;
      }
      finished = stop.reason.empty() && !tripped;
    } else {
      Deliver(messages_);
    }
  } catch (const IoError& error) {
    stop = {std::string("io_error: ") + error.what(), tick_at};
    const std::lock_guard lock(mutex_);
    Latch({.name = "io_error", .index = next_index_, .text = error.what()});
  } catch (const std::exception& error) {
    stop = {std::string("internal: ") + error.what(), tick_at};
    const std::lock_guard lock(mutex_);
    Latch({.name = "internal", .index = next_index_, .text = error.what()});
  }
  Finish(std::move(stop), finished);
  return std::nullopt;
}

void PacedRig::Finish(Stop stop, bool finished) {
  {
    const std::lock_guard lock(mutex_);
    state_ = RigState::kStopping;
  }
  std::optional<Trip> machine_trip;
  std::string unsafe;
  {
    const std::lock_guard machine_lock(machine_mutex_);
    unsafe = machine_->MakeSafe();
    machine_trip = machine_->trip();
  }
  if (options_.heartbeat && unsafe.empty()) options_.heartbeat->End();
  if (machine_trip) stop.reason = machine_trip->name + ": " + machine_trip->text;
  if (!unsafe.empty()) stop.reason += (stop.reason.empty() ? "unsafe: " : "; unsafe: ") + unsafe;
  const bool tripped = machine_trip || !unsafe.empty();
  const std::lock_guard lock(mutex_);
  if (unsafe.empty()) NoteSafe(stop.cause_at);
  if (machine_trip) Latch(*machine_trip);
  if (!unsafe.empty()) Latch({.name = "unsafe", .index = next_index_, .text = unsafe});
  if (trip_) {
    queue_.PushLast(RigEvent{.kind = RigEventKind::kTrip,
                             .index = trip_->index,
                             .value = trip_->value,
                             .text = trip_->name + ": " + trip_->text});
  }
  const bool stopped = !finished || tripped;
  queue_.PushLast(RigEvent{.kind = stopped ? RigEventKind::kStopped : RigEventKind::kFinished,
                           .index = next_index_,
                           .value = stopped && safe_after_ ? Seconds(*safe_after_) : 0.0,
                           .text = std::move(stop.reason)});
  queue_.Close();
  state_ = trip_ ? RigState::kTripped : RigState::kIdle;
  state_changed_.notify_all();
}

}  // namespace faultlab::hardware

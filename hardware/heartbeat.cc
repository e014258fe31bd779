#include "hardware/heartbeat.h"

#include <algorithm>
#include <utility>

#include "core/types/check.h"

namespace faultlab::hardware {
namespace {

constexpr Nanoseconds kStep = std::chrono::milliseconds(10);
constexpr Word kNow = 1;
constexpr std::int64_t kStepsMax = kCallForHelp - 1 - kNow;

}  // namespace

Word NextTickIn(Nanoseconds time) {
  return static_cast<Word>(kNow + std::clamp<std::int64_t>(time / kStep, 0, kStepsMax));
}

Nanoseconds SilenceAllowed(Word word, Nanoseconds silence_max) {
  return silence_max + (word - kNow) * kStep;
}

Heartbeat::Heartbeat(SendWord send, std::shared_ptr<Clock> clock, Options options)
    : send_(std::move(send)), clock_(std::move(clock)), options_(options) {
  LAB_CHECK(send_ && clock_);
}

void Heartbeat::Begin() {
  MainLoopTurn();
  sent_at_ = clock_->Now();
  send_(NextTickIn(options_.driver_slack));
}

void Heartbeat::Beat(Nanoseconds next) {
  const Nanoseconds now = clock_->Now();
  const Nanoseconds main_turn(main_turn_ns_.load(std::memory_order_relaxed));
  if (now - main_turn > options_.main_loop_silence) return;
  if (now - sent_at_ < options_.word_every && next < options_.word_every) return;
  sent_at_ = now;
  send_(NextTickIn(next + options_.driver_slack));
}

void Heartbeat::End() {
  send_(kMotorOff);
}

void Heartbeat::MainLoopTurn() {
  main_turn_ns_.store(clock_->Now().count(), std::memory_order_relaxed);
}

}  // namespace faultlab::hardware

#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>

#include "hardware/clock.h"

namespace faultlab::hardware {

/// What the process that drives a rig says to its supervisor (supervisor.h): one byte.
///   kMotorOff     drive 0: silence means nothing until the next word
///   kCallForHelp  the driver hangs
///   others        the motor is driven by a live loop, which speaks again in time
using Word = std::uint8_t;
inline constexpr Word kMotorOff = 0;
inline constexpr Word kCallForHelp = 255;
/// The loop's next tick is due in `time`: 0 to 2.5 s, in steps of 10 ms.
Word NextTickIn(Nanoseconds time);
/// How late a word may be before its sender is taken for dead.
inline constexpr Nanoseconds kSilenceMax = std::chrono::milliseconds(300);
/// After NextTickIn(time): time (rounded down) + silence_max.
Nanoseconds SilenceAllowed(Word word, Nanoseconds silence_max = kSilenceMax);

/// Says a word, from any thread; never waits: a word that finds no room is lost.
using SendWord = std::function<void(Word)>;

/// Proof for the supervisor that what drives the motor is alive. Two threads must be:
///   the paced loop   says the words itself, so that a loop that stands still says nothing
///   the main loop    of the agent, which hears the stop command: without a turn of it for
///                    main_loop_silence the paced loop says nothing either
///
///   Begin -> Beat, Beat, .. -> End        MainLoopTurn, MainLoopTurn, ..
class Heartbeat {
 public:
  struct Options {
    /// Longer than the 500 ms after which a silent holder stops the run: that stop comes first.
    Nanoseconds main_loop_silence = std::chrono::seconds(1);
    /// Ticks come faster than the supervisor needs to hear of them.
    Nanoseconds word_every = std::chrono::milliseconds(50);
    /// How much longer than 250 ms a tick may wait for the driver (driver_timeout_ms).
    Nanoseconds driver_slack{0};
  };

  Heartbeat(SendWord send, std::shared_ptr<Clock> clock) : Heartbeat(send, clock, Options()) {}
  Heartbeat(SendWord send, std::shared_ptr<Clock> clock, Options options);

  /// Before the first drive of a run, by the thread that starts it.
  void Begin();
  /// At each tick, by the loop's thread; the next one comes in `next`.
  void Beat(Nanoseconds next);
  /// The bench is safe. Not called when it could not be made so: then silence brings the
  /// supervisor.
  void End();
  /// At each turn of the main loop. From any thread.
  void MainLoopTurn();

 private:
  const SendWord send_;
  const std::shared_ptr<Clock> clock_;
  const Options options_;
  std::atomic<std::int64_t> main_turn_ns_{0};
  Nanoseconds sent_at_{0};  ///< of Begin, then of the loop's thread
};

}  // namespace faultlab::hardware

#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "core/types/component.h"
#include "hardware/clock.h"
#include "hardware/daq/daq.h"

namespace faultlab::hardware {

inline constexpr int kRelayBoards = 4;  ///< R1, R9, R12, C8
inline constexpr std::array<core::Component, kRelayBoards> kRelayComponents = {
    core::Component::kR1, core::Component::kR9, core::Component::kR12, core::Component::kC8};

/// Which line connects which value: paper Table 2. line[board][position], position 0 = nominal.
/// The boards have their lines in fours, {16,17,0,1}, {18,19,2,3}, {20,21,4,5}, {22,23,6,7}: so the
/// table's "Do156 ohm" is Do1, 56 ohm.
struct RelayWiring {
  std::array<std::array<int, core::kRelayPositions>, kRelayBoards> line = {{
      {17, 16, 1, 0},  // R1: 1, 10, 56, 100 ohm
      {19, 18, 3, 2},  // R9: 10, 33, 56, 100 kohm
      {6, 7, 22, 23},  // R12: 10, 5.6, 3.3, 2 kohm
      {21, 20, 5, 4},  // C8: 47 pF, 1, 10, 47 uF
  }};
  /// Level 0 makes the transistor conduct and the relay connect its part (paper section 2.1.4).
  bool inverted = true;

  /// The lines that belong to relays: bit i is line Do<i>.
  std::uint32_t mask() const {
    std::uint32_t lines = 0;
    for (const auto& board : line) {
      for (const int one : board) lines |= 1u << one;
    }
    return lines;
  }
};

struct RelayTiming {
  Nanoseconds gap = std::chrono::milliseconds(3);     ///< between break and make, or make and break
  Nanoseconds settle = std::chrono::milliseconds(3);  ///< before the last read-back
};

/// The four relay boards of a bench: one position each, switched in the order that each needs.
///   R1, R9, C8   break before make: two parts are never connected at once
///   R12          make before break: it closes the amplifier's feedback, which must never be open
/// All boards of one request switch in parallel, in stages with waits between:
///   first half -> gap -> read back, second half -> settle -> read back
/// Each stage is written and read back; a mismatch ends the switching before anything is added.
class RelayBoard {
 public:
  enum class Progress { kWait, kConfirmed, kMismatch };
  struct Stage {
    Progress progress = Progress::kConfirmed;
    Nanoseconds wait{0};  ///< before the next Advance
    std::string text;     ///< of a mismatch
  };

  /// Contract: the wiring's 16 lines are different and in [0, 32).
  RelayBoard(Daq& daq, RelayWiring wiring, RelayTiming timing);

  /// Wants `position` (0..3) on a board; Advance makes it so.
  /// Contract: IsRelaySwitched(component), position in range.
  void Request(core::Component component, int position);
  /// Does the next stage of what was requested.
  Stage Advance();
  bool busy() const { return stage_ != 0 || wanted_ != position_; }

  /// For a bench in an unknown state: nominal everywhere in two stages with a gap between, by the
  /// order of each board. Boards that read nominal do not move.
  void ForceNominalFirst();
  void ForceNominalSecond();
  /// Empty when the lines read back as written last; else what differs, the first line by name.
  std::string ReadbackDifference();

  /// Position confirmed by the last read-back.
  int position(core::Component component) const;
  int line(core::Component component, int position) const;
  const RelayTiming& timing() const { return timing_; }
  /// Longest time that one request takes.
  Nanoseconds duration() const { return timing_.gap + timing_.settle; }

  /// The levels in which exactly these positions are connected.
  std::uint32_t LevelsOf(const std::array<int, kRelayBoards>& positions) const;

 private:
  std::uint32_t Connected(std::uint32_t levels) const;
  std::uint32_t Bit(std::size_t board, int position) const;
  Stage Write(std::uint32_t connected, Nanoseconds wait);
  bool Verify(Stage& stage);

  Daq& daq_;
  const RelayWiring wiring_;
  const RelayTiming timing_;
  std::uint32_t mask_ = 0;
  std::array<int, kRelayBoards> position_{};  ///< confirmed
  std::array<int, kRelayBoards> target_{};    ///< of the switching under way
  std::array<int, kRelayBoards> wanted_{};    ///< of the next one
  std::uint32_t connected_ = 0;               ///< written last: bit i = line i connects its part
  int stage_ = 0;
};

/// Position of `value` on its board, -1 if no relay connects it. Values within 1e-6 relative.
int RelayPositionOf(core::Component component, double value);

}  // namespace faultlab::hardware

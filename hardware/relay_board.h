#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/bench/bench.h"
#include "core/types/component.h"
#include "hardware/clock.h"
#include "hardware/relay_lines.h"

namespace faultlab::hardware {

/// A relay board for each switched component of a bench; the component knows its values and lines.
struct RelayWiring {
  std::vector<core::Component> boards;
  /// Level 0 makes the transistor conduct and the relay connect its part (paper section 2.1.4).
  bool inverted = true;

  /// The lines that belong to relays: bit i is line Do<i>.
  std::uint32_t mask() const {
    std::uint32_t lines = 0;
    for (const core::Component board : boards) {
      for (const core::SwitchPosition& position : board.info().positions) {
        lines |= 1u << position.line;
      }
    }
    return lines;
  }
  /// The levels at which every board connects its nominal part and nothing else.
  std::uint32_t nominal_levels() const {
    std::uint32_t connected = 0;
    for (const core::Component board : boards) {
      connected |= 1u << board.info().positions.front().line;
    }
    return inverted ? ~connected : connected;
  }
};
RelayWiring WiringOf(const core::Bench& bench);

struct RelayTiming {
  Nanoseconds gap = std::chrono::milliseconds(3);     ///< between break and make, or make and break
  Nanoseconds settle = std::chrono::milliseconds(3);  ///< before the last read-back
};

/// The relay boards of a bench: one position each, switched in the order that each needs
/// (core::SwitchOrder).
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

  /// Contract: the wiring's lines are different and in [0, 32).
  RelayBoard(RelayLines& lines, RelayWiring wiring, RelayTiming timing);

  /// Wants `position` (0 = nominal) on a board; Advance makes it so.
  /// Contract: IsSwitched(component), position in range.
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
  /// Longest time that one request takes; none without boards.
  Nanoseconds duration() const {
    return boards() > 0 ? timing_.gap + timing_.settle : Nanoseconds(0);
  }

  /// The levels in which exactly these positions are connected.
  std::uint32_t LevelsOf(const std::vector<int>& positions) const;

 private:
  std::uint32_t Connected(std::uint32_t levels) const;
  std::uint32_t Bit(std::size_t board, int position) const;
  std::size_t BoardOf(core::Component component) const;
  std::size_t boards() const { return wiring_.boards.size(); }
  bool MakesBeforeBreak(std::size_t board) const {
    return wiring_.boards[board].info().order == core::SwitchOrder::kMakeBeforeBreak;
  }
  Stage Write(std::uint32_t connected, Nanoseconds wait);
  bool Verify(Stage& stage);

  RelayLines& lines_;
  const RelayWiring wiring_;
  const RelayTiming timing_;
  std::uint32_t mask_ = 0;
  std::vector<int> position_;    ///< of each board, confirmed
  std::vector<int> target_;      ///< of the switching under way
  std::vector<int> wanted_;      ///< of the next one
  std::uint32_t connected_ = 0;  ///< written last: bit i = line i connects its part
  int stage_ = 0;
};

/// Position of `value` on its board, -1 if no relay connects it. Values within 1e-6 relative.
int RelayPositionOf(core::Component component, double value);

}  // namespace faultlab::hardware

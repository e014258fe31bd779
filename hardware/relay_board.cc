#include "hardware/relay_board.h"

#include <bit>
#include <cmath>
#include <cstdio>

#include "core/types/check.h"

namespace faultlab::hardware {
namespace {

/// Two doubles that name the same part; far below the 1 % of any resistor.
constexpr double kSameValue = 1e-6;

bool MakesBeforeBreak(std::size_t board) {
  return kRelayComponents[board] == core::Component::kR12;
}

std::size_t BoardOf(core::Component component) {
  for (std::size_t board = 0; board < kRelayComponents.size(); ++board) {
    if (kRelayComponents[board] == component) return board;
  }
  LAB_CHECK(false, core::Name(component));
  return 0;
}

std::string Hex(std::uint32_t value) {
  char text[16];
  std::snprintf(text, sizeof text, "0x%08x", value);
  return text;
}

}  // namespace

int RelayPositionOf(core::Component component, double value) {
  const auto& values = core::RelayValues(component);
  for (int position = 0; position < core::kRelayPositions; ++position) {
    const double known = values[static_cast<std::size_t>(position)];
    if (std::abs(value - known) <= kSameValue * known) return position;
  }
  return -1;
}

RelayBoard::RelayBoard(Daq& daq, RelayWiring wiring, RelayTiming timing)
    : daq_(daq), wiring_(wiring), timing_(timing) {
  for (const auto& board : wiring_.line) {
    for (int line : board) {
      LAB_CHECK(line >= 0 && line < 32, line);
      LAB_CHECK((mask_ & (1u << line)) == 0, line);
      mask_ |= 1u << line;
    }
  }
  for (std::size_t board = 0; board < kRelayBoards; ++board) connected_ |= Bit(board, 0);
}

std::uint32_t RelayBoard::Bit(std::size_t board, int position) const {
  return 1u << wiring_.line[board][static_cast<std::size_t>(position)];
}

int RelayBoard::line(core::Component component, int position) const {
  return wiring_.line[BoardOf(component)][static_cast<std::size_t>(position)];
}

int RelayBoard::position(core::Component component) const {
  return position_[BoardOf(component)];
}

std::uint32_t RelayBoard::Connected(std::uint32_t levels) const {
  return (wiring_.inverted ? ~levels : levels) & mask_;
}

std::uint32_t RelayBoard::LevelsOf(const std::array<int, kRelayBoards>& positions) const {
  std::uint32_t connected = 0;
  for (std::size_t board = 0; board < kRelayBoards; ++board) {
    connected |= Bit(board, positions[board]);
  }
  return wiring_.inverted ? ~connected : connected;
}

void RelayBoard::Request(core::Component component, int position) {
  LAB_CHECK(position >= 0 && position < core::kRelayPositions, position);
  wanted_[BoardOf(component)] = position;
}

RelayBoard::Stage RelayBoard::Write(std::uint32_t connected, Nanoseconds wait) {
  connected_ = connected;
  daq_.WriteRelayLines(wiring_.inverted ? ~connected : connected);
  return {.progress = Progress::kWait, .wait = wait, .text = {}};
}

std::string RelayBoard::ReadbackDifference() {
  const std::uint32_t seen = Connected(daq_.ReadRelayLines());
  if (seen == connected_) return {};
  return "relay lines " + Hex(connected_) + " were written, " + Hex(seen) +
         " are read back (first difference: Do" +
         std::to_string(std::countr_zero(seen ^ connected_)) + ")";
}

bool RelayBoard::Verify(Stage& stage) {
  stage.text = ReadbackDifference();
  if (stage.text.empty()) return true;
  stage.progress = Progress::kMismatch;
  stage_ = 0;
  wanted_ = position_;
  return false;
}

RelayBoard::Stage RelayBoard::Advance() {
  Stage stage;
  if (stage_ > 0 && !Verify(stage)) return stage;
  if (stage_ == 0) {
    if (wanted_ == position_) return stage;
    target_ = wanted_;
    std::uint32_t connected = 0;
    for (std::size_t board = 0; board < kRelayBoards; ++board) {
      if (target_[board] == position_[board]) {
        connected |= Bit(board, position_[board]);
      } else if (MakesBeforeBreak(board)) {
        connected |= Bit(board, position_[board]) | Bit(board, target_[board]);
      }
    }
    stage_ = 1;
    return Write(connected, timing_.gap);
  }
  if (stage_ == 1) {
    std::uint32_t connected = 0;
    for (std::size_t board = 0; board < kRelayBoards; ++board) {
      connected |= Bit(board, target_[board]);
    }
    stage_ = 2;
    return Write(connected, timing_.settle);
  }
  stage_ = 0;
  position_ = target_;
  return stage;
}

void RelayBoard::ForceNominalFirst() {
  std::uint32_t seen = connected_;
  try {
    seen = Connected(daq_.ReadRelayLines());
  } catch (const IoError&) {
    // The lines do not answer: go by what was written last.
  }
  std::uint32_t connected = 0;
  for (std::size_t board = 0; board < kRelayBoards; ++board) {
    std::uint32_t lines = 0;
    for (int position = 0; position < core::kRelayPositions; ++position) {
      lines |= Bit(board, position);
    }
    const std::uint32_t nominal = Bit(board, 0);
    if ((seen & lines) == nominal) {
      connected |= nominal;
    } else if (MakesBeforeBreak(board)) {
      connected |= nominal | (seen & lines);
    }
  }
  Write(connected, timing_.gap);
}

void RelayBoard::ForceNominalSecond() {
  std::uint32_t connected = 0;
  for (std::size_t board = 0; board < kRelayBoards; ++board) connected |= Bit(board, 0);
  stage_ = 0;
  position_ = target_ = wanted_ = {};
  Write(connected, timing_.settle);
}

}  // namespace faultlab::hardware

#include "hardware/relay_board.h"

#include <cmath>
#include <utility>

#include "core/types/check.h"
#include "hardware/io_error.h"

namespace faultlab::hardware {
namespace {

/// Two doubles that name the same part; far below the 1 % of any resistor.
constexpr double kSameValue = 1e-6;

}  // namespace

int RelayPositionOf(core::Component component, double value) {
  const auto& positions = component.info().positions;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const double known = positions[i].value;
    if (std::abs(value - known) <= kSameValue * known) return static_cast<int>(i);
  }
  return -1;
}

RelayWiring WiringOf(const core::Bench& bench) {
  RelayWiring wiring;
  for (const core::Component component : bench.components()) {
    if (core::IsSwitched(component)) wiring.boards.push_back(component);
  }
  return wiring;
}

std::size_t RelayBoard::BoardOf(core::Component component) const {
  for (std::size_t board = 0; board < boards(); ++board) {
    if (wiring_.boards[board] == component) return board;
  }
  LAB_CHECK(false, core::Name(component));
  return 0;
}

RelayBoard::RelayBoard(RelayLines& lines, RelayWiring wiring, RelayTiming timing)
    : lines_(lines),
      wiring_(std::move(wiring)),
      timing_(timing),
      position_(wiring_.boards.size()),
      target_(wiring_.boards.size()),
      wanted_(wiring_.boards.size()) {
  for (const core::Component board : wiring_.boards) {
    for (const core::SwitchPosition& position : board.info().positions) {
      LAB_CHECK(position.line >= 0 && position.line < 32, position.line);
      LAB_CHECK((mask_ & (1u << position.line)) == 0, position.line);
      mask_ |= 1u << position.line;
    }
  }
  for (std::size_t board = 0; board < boards(); ++board) connected_ |= Bit(board, 0);
}

std::uint32_t RelayBoard::Bit(std::size_t board, int position) const {
  return 1u << wiring_.boards[board].info().positions[static_cast<std::size_t>(position)].line;
}

int RelayBoard::line(core::Component component, int position) const {
  return component.info().positions[static_cast<std::size_t>(position)].line;
}

int RelayBoard::position(core::Component component) const {
  return position_[BoardOf(component)];
}

std::uint32_t RelayBoard::Connected(std::uint32_t levels) const {
  return (wiring_.inverted ? ~levels : levels) & mask_;
}

std::uint32_t RelayBoard::LevelsOf(const std::vector<int>& positions) const {
  std::uint32_t connected = 0;
  for (std::size_t board = 0; board < boards(); ++board) {
    connected |= Bit(board, positions[board]);
  }
  return wiring_.inverted ? ~connected : connected;
}

void RelayBoard::Request(core::Component component, int position) {
  LAB_CHECK(position >= 0 && position < static_cast<int>(component.info().positions.size()),
            position);
  wanted_[BoardOf(component)] = position;
}

RelayBoard::Stage RelayBoard::Write(std::uint32_t connected, Nanoseconds wait) {
  connected_ = connected;
  lines_.WriteRelayLines(wiring_.inverted ? ~connected : connected);
  return {.progress = Progress::kWait, .wait = wait, .text = {}};
}

std::string RelayBoard::ReadbackDifference() {
  const std::uint32_t seen = Connected(lines_.ReadRelayLines());
  if (seen == connected_) return {};
  return LineDifference(connected_, seen);
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
    for (std::size_t board = 0; board < boards(); ++board) {
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
    for (std::size_t board = 0; board < boards(); ++board) {
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
    seen = Connected(lines_.ReadRelayLines());
  } catch (const IoError&) {
    // The lines do not answer: go by what was written last.
  }
  std::uint32_t connected = 0;
  for (std::size_t board = 0; board < boards(); ++board) {
    std::uint32_t lines = 0;
    for (const core::SwitchPosition& position : wiring_.boards[board].info().positions) {
      lines |= 1u << position.line;
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
  for (std::size_t board = 0; board < boards(); ++board) connected |= Bit(board, 0);
  stage_ = 0;
  position_.assign(boards(), 0);
  target_ = wanted_ = position_;
  Write(connected, timing_.settle);
}

}  // namespace faultlab::hardware

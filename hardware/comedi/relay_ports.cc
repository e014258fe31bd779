#include "hardware/comedi/relay_ports.h"

#include <string>

namespace faultlab::hardware {

RelayPorts::RelayPorts(const ComediBoard& board, const ComediChannels& channels) : board_(board) {
  for (int line = 0; line < 32; ++line) {
    if ((channels.relay_lines & 1u << line) != 0) Place(line, channels);
  }
  for (const Port& port : ports_) MakeOutputs(port, channels.nominal_levels);
}

void RelayPorts::Place(int line, const ComediChannels& channels) {
  int channel = channels.relay_base + line;
  int lines = 0;
  std::string there;
  for (const int subdevice : channels.digital) {
    const int here = board_.Require("digital", subdevice, COMEDI_SUBD_DIO, COMEDI_SUBD_DO);
    lines += here;
    there += (there.empty() ? "" : ", ") + std::string("subdevice ") + std::to_string(subdevice) +
             " of " + board_.name() + " has " + std::to_string(here) + " lines";
    if (channel >= here) {
      channel -= here;
      continue;
    }
    const unsigned base = Unsigned(channel) / 32 * 32;
    const Line found{.bit = Unsigned(channel) - base, .of = 1u << line};
    for (Port& port : ports_) {
      if (port.subdevice != subdevice || port.base != base) continue;
      port.lines.push_back(found);
      return;
    }
    const int type = board_.api().get_type(board_.device(), Unsigned(subdevice));
    ports_.push_back({.subdevice = subdevice,
                      .base = base,
                      .has_direction = type == COMEDI_SUBD_DIO,
                      .lines = {found}});
    return;
  }
  const std::string base =
      channels.relay_base == 0 ? "" : " behind relay_base " + std::to_string(channels.relay_base);
  throw IoError(there + ", the description's relays use line " + std::to_string(line) + base +
                ": name more subdevices in comedi.digital, or lower `lines` in the description");
}

/// What the kernel does: dio_config (INSN_CONFIG) sets a direction, dio_bitfield2 (INSN_BITS) a
/// latch, of inputs too. On most boards a latch written before shows when its line becomes an
/// output, so the levels are written first. An 8255 clears the latches of all its 24 lines whenever
/// a direction changes, and changes it for 8 or 4 lines at once: therefore the levels are written
/// again after each change, and lines that became outputs along with another are not configured.
/// Between the two calls all its relays are on, for some microseconds; a relay takes milliseconds.
void RelayPorts::MakeOutputs(const Port& port, std::uint32_t nominal_levels) const {
  if (!port.has_direction) return;
  const std::uint32_t now = Bits(port, 0, 0);
  std::uint32_t mask = 0;
  std::uint32_t levels = 0;
  std::vector<Line> inputs;
  for (const Line& line : port.lines) {
    mask |= 1u << line.bit;
    const bool output = IsOutput(port, line);
    if (!output) inputs.push_back(line);
    const bool high = output ? (now >> line.bit & 1u) != 0 : (nominal_levels & line.of) != 0;
    levels |= (high ? 1u : 0u) << line.bit;
  }
  if (inputs.empty()) return;
  (void)Bits(port, mask, levels);
  for (const Line& line : inputs) {
    if (IsOutput(port, line)) continue;
    const int status = board_.api().dio_config(
        board_.device(), Unsigned(port.subdevice), port.base + line.bit, COMEDI_OUTPUT);
    if (status < 0) {
      board_.Fail("comedi_dio_config of line " + std::to_string(port.base + line.bit) +
                  " of subdevice " + std::to_string(port.subdevice));
    }
    (void)Bits(port, mask, levels);
  }
}

/// A driver that cannot say so has inputs.
bool RelayPorts::IsOutput(const Port& port, const Line& line) const {
  unsigned direction = COMEDI_INPUT;
  const int status = board_.api().dio_get_config(
      board_.device(), Unsigned(port.subdevice), port.base + line.bit, &direction);
  return status >= 0 && direction == COMEDI_OUTPUT;
}

void RelayPorts::Write(std::uint32_t levels) const {
  for (const Port& port : ports_) {
    std::uint32_t mask = 0;
    std::uint32_t bits = 0;
    for (const Line& line : port.lines) {
      mask |= 1u << line.bit;
      if ((levels & line.of) != 0) bits |= 1u << line.bit;
    }
    (void)Bits(port, mask, bits);
  }
}

std::uint32_t RelayPorts::Read() const {
  std::uint32_t levels = 0;
  for (const Port& port : ports_) {
    const std::uint32_t bits = Bits(port, 0, 0);
    for (const Line& line : port.lines) {
      if ((bits >> line.bit & 1u) != 0) levels |= line.of;
    }
  }
  return levels;
}

std::uint32_t RelayPorts::Bits(const Port& port, std::uint32_t mask, std::uint32_t bits) const {
  unsigned levels = bits;
  const int status = board_.api().dio_bitfield2(
      board_.device(), Unsigned(port.subdevice), mask, &levels, port.base);
  if (status < 0)
    board_.Fail("comedi_dio_bitfield2 of subdevice " + std::to_string(port.subdevice));
  return levels;
}

}  // namespace faultlab::hardware

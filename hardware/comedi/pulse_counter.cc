#include "hardware/comedi/pulse_counter.h"

#include <cerrno>

namespace faultlab::hardware {

PulseCounter::PulseCounter(const ComediBoard& board, const ComediChannels& channels)
    : board_(board),
      subdevice_(Unsigned(channels.counter)),
      channel_(Unsigned(channels.counter_channel)),
      direction_(channels.counts) {
  const int there = board.Require("counter", channels.counter, COMEDI_SUBD_COUNTER);
  board.RequireChannel("counter_channel", channels.counter_channel, channels.counter, there);
  const lsampl_t maxdata = board.api().get_maxdata(board.device(), subdevice_, channel_);
  if (maxdata == 0) board.Fail("comedi_get_maxdata of the counter");
  modulus_ = std::uint64_t{maxdata} + 1;
  // Simple counters have no such instructions (EINVAL): they count from power-up.
  const auto try_to = [&](int status, const char* call) {
    if (status < 0 && board.api().error_number() != EINVAL) board.Fail(call);
  };
  try_to(board.api().reset(board.device(), subdevice_), "comedi_reset");
  try_to(board.api().arm(board.device(), subdevice_, 0), "comedi_arm");
}

std::uint32_t PulseCounter::Read() {
  lsampl_t count = 0;
  const int status = board_.api().data_read(board_.device(), subdevice_, channel_, 0, 0, &count);
  if (status < 0) board_.Fail("comedi_data_read of the counter");
  const std::uint64_t before = before_.value_or(count);
  before_ = count;
  const std::uint64_t up = (count + modulus_ - before) % modulus_;
  const std::uint64_t down = (before + modulus_ - count) % modulus_;
  const bool backwards = direction_ == CountDirection::kBoth && down < up;
  const std::uint64_t steps = direction_ == CountDirection::kDown || backwards ? down : up;
  pulses_ += static_cast<std::uint32_t>(backwards ? -steps : steps);
  return pulses_;
}

}  // namespace faultlab::hardware

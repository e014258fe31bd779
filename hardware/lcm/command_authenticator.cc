#include "hardware/lcm/command_authenticator.h"

#include <utility>

#include "hardware/lcm/sealed_message.h"

namespace faultlab::hardware {
namespace {

constexpr std::size_t kRepliesKept = 64;
/// Holders need the key, so only our own servers can fill this.
constexpr std::size_t kHoldersMax = 4096;

}  // namespace

CommandAuthenticator::Verdict CommandAuthenticator::Check(MessageBus::Bytes bytes,
                                                          Command& command) {
  std::optional<Command> said = Opened<Command>(bytes, channel_, rig_, key_);
  if (!said) return Verdict::kForged;
  if (said->boot != boot_) return Verdict::kReplayed;
  const auto known = counters_.find(said->holder);
  const bool refused =
      known == counters_.end() ? counters_.size() >= kHoldersMax : said->counter <= known->second;
  if (refused) return Verdict::kReplayed;
  counters_[said->holder] = said->counter;
  command = std::move(*said);
  return Remembered(command) != nullptr ? Verdict::kRepeated : Verdict::kNew;
}

const CommandAuthenticator::Reply* CommandAuthenticator::Remembered(const Command& command) const {
  for (const Reply& before : replies_) {
    if (before.holder == command.holder && before.request == command.request) return &before;
  }
  return nullptr;
}

void CommandAuthenticator::Remember(Reply reply) {
  replies_.push_back(std::move(reply));
  if (replies_.size() > kRepliesKept) replies_.pop_front();
}

}  // namespace faultlab::hardware

#include "server/stream/stream_tokens.h"

#include <sys/random.h>

#include <set>
#include <vector>

#include "core/types/check.h"

namespace faultlab::server {

std::string RandomCode(int bytes) {
  constexpr std::string_view kLetters = "abcdefghijklmnopqrstuvwxyz234567";
  std::vector<unsigned char> random(static_cast<std::size_t>(bytes));
  const ssize_t got = getrandom(random.data(), random.size(), 0);
  LAB_CHECK(got == static_cast<ssize_t>(random.size()), got);
  std::string out;
  unsigned int bits = 0;
  int held = 0;
  for (const unsigned char byte : random) {
    bits = (bits << 8) | byte;
    held += 8;
    while (held >= 5) {
      held -= 5;
      out.push_back(kLetters[(bits >> held) & 31]);
    }
  }
  if (held > 0) out.push_back(kLetters[(bits << (5 - held)) & 31]);
  return out;
}

void StreamTokens::DropExpired(MonotonicTime now) {
  std::erase_if(entries_, [now](const auto& entry) { return entry.second.expires <= now; });
}

std::string StreamTokens::Issue(StreamGrant grant) {
  std::string code = issuer_ + "." + RandomCode(16);
  const std::lock_guard lock(mutex_);
  const MonotonicTime now = clock_.Monotonic();
  if (entries_.size() >= limits_.codes_per_caller_max) DropExpired(now);
  const ViewerOwner& owner = grant.owner;
  KeepBelow(limits_.codes_per_caller_max,
            [&owner](const ViewerOwner& other) { return other.caller == owner.caller; });
  if (owner.guest()) {
    KeepBelow((limits_.codes_max + 1) / 2, [](const ViewerOwner& other) { return other.guest(); });
  }
  KeepBelow(limits_.codes_max, [](const ViewerOwner&) { return true; });
  entries_.emplace(code, Entry{std::move(grant), now + kStreamTokenLife, ++issued_});
  return code;
}

void StreamTokens::KeepBelow(std::size_t max,
                             const std::function<bool(const ViewerOwner&)>& which) {
  if (entries_.size() < max) return;
  std::size_t count = 0;
  auto oldest = entries_.end();
  for (auto it = entries_.begin(); it != entries_.end(); ++it) {
    if (!which(it->second.grant.owner)) continue;
    ++count;
    if (oldest == entries_.end() || it->second.number < oldest->second.number) oldest = it;
  }
  if (count >= max) entries_.erase(oldest);
}

std::vector<ViewerOwner> StreamTokens::Owners() {
  const std::lock_guard lock(mutex_);
  std::set<ViewerOwner> known;
  for (const auto& [code, entry] : entries_) known.insert(entry.grant.owner);
  return {known.begin(), known.end()};
}

void StreamTokens::Drop(const std::function<bool(const ViewerOwner&)>& which) {
  const std::lock_guard lock(mutex_);
  std::erase_if(entries_, [&](const auto& entry) { return which(entry.second.grant.owner); });
}

std::string_view StreamTokens::IssuerOf(std::string_view code) {
  const std::size_t end = code.rfind('.');
  return end == std::string_view::npos ? std::string_view() : code.substr(0, end);
}

std::optional<StreamGrant> StreamTokens::Redeem(std::string_view code) {
  const std::lock_guard lock(mutex_);
  const auto entry = entries_.find(std::string(code));
  if (entry == entries_.end()) return std::nullopt;
  const bool alive = clock_.Monotonic() < entry->second.expires;
  StreamGrant grant = std::move(entry->second.grant);
  entries_.erase(entry);
  if (!alive) return std::nullopt;
  return grant;
}

}  // namespace faultlab::server

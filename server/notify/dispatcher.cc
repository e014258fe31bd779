#include "server/notify/dispatcher.h"

#include <algorithm>
#include <exception>
#include <utility>

namespace faultlab::server::notify {
namespace {

using Outcome = Attempt::Outcome;
using std::chrono::milliseconds;
using std::chrono::minutes;
using std::chrono::seconds;

constexpr int kWorkers = 4;
/// So many of them at most wait for programs of people: the others are the lab's.
constexpr std::size_t kForPeople = 2;
constexpr seconds kLookEvery{1};
constexpr minutes kTidyEvery{10};
constexpr seconds kRestMax{30};
constexpr std::chrono::hours kPauseMax{1};
/// The database was away when the outcome was to be stored.
constexpr milliseconds kStoreAgain{500};

/// first, 2 first, 4 first .. most
milliseconds Growing(milliseconds first, std::int64_t times, milliseconds most) {
  constexpr std::int64_t kDoublings = 20;
  const std::int64_t factor = std::int64_t{1} << std::clamp<std::int64_t>(times - 1, 0, kDoublings);
  return std::min(most, first * factor);
}

}  // namespace

Dispatcher::Dispatcher(Parts parts, NewsOptions options)
    : parts_(std::move(parts)),
      options_(std::move(options)),
      outbox_(parts_.database),
      webhooks_(parts_.database) {
  for (int i = 0; i < kWorkers; ++i) workers_.emplace_back([this] { Work(); });
  looker_.emplace(parts_.clock, Repeated::First::kAtOnce, kLookEvery, [this] { Look(); });
}

Dispatcher::~Dispatcher() {
  looker_.reset();
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  for (std::thread& worker : workers_) worker.join();
}

/// What one channel cannot read, or takes long to read, keeps no other from being sent.
void Dispatcher::Look() {
  const WallTime now = parts_.service.Now();
  const auto take = [&](const core::Result<bool>& gathered) {
    if (!gathered.ok()) Log(gathered.error());
    if (!gathered.ok() || !gathered.value()) return;
    const std::lock_guard lock(mutex_);
    ++looks_;
    wake_.notify_all();
  };
  take(Gather(parts_.database, options_, now));
  for (Channel* channel : parts_.channels) take(channel->Gather(now));
  if (parts_.clock.Monotonic() - tidied_ < kTidyEvery) return;
  tidied_ = parts_.clock.Monotonic();
  const core::Status tidy = outbox_.Tidy(now);
  if (!tidy.ok()) Log(tidy.error());
}

void Dispatcher::Work() {
  std::uint64_t seen = 0;
  std::unique_lock lock(mutex_);
  while (true) {
    wake_.wait(lock, [&] { return stopping_ || looks_ != seen; });
    seen = looks_;
    while (!stopping_) {
      lock.unlock();
      const auto claimed = Claim();
      if (!claimed.ok()) Log(claimed.error());
      if (claimed.ok() && claimed.value()) Store(*claimed.value(), Send(*claimed.value()));
      lock.lock();
      if (!claimed.ok() || !claimed.value()) break;
      busy_.erase(claimed.value()->channel);
      for_people_.erase(claimed.value()->channel);
      ++looks_;  // others may have passed over this channel
      wake_.notify_all();
    }
    if (stopping_) return;
  }
}

/// One after the other, so that a channel is not claimed twice.
core::Result<std::optional<Message>> Dispatcher::Claim() {
  const std::lock_guard claiming(claiming_);
  std::set<std::string> not_these;
  for (const Channel* channel : parts_.channels) {
    if (!channel->is_on()) not_these.emplace(channel->prefix());
  }
  {
    const std::lock_guard lock(mutex_);
    not_these.insert(busy_.begin(), busy_.end());
    const MonotonicTime now = parts_.clock.Monotonic();
    for (const auto& [channel, rest] : rests_) {
      if (rest.until > now) not_these.insert(channel);
    }
  }
  bool of_people = true;
  {
    const std::lock_guard lock(mutex_);
    of_people = for_people_.size() < kForPeople;
  }
  auto claimed = outbox_.Claim(
      {parts_.service.member(), parts_.service.boot()}, not_these, of_people, parts_.service.Now());
  if (claimed.ok() && claimed.value()) {
    const std::string& channel = claimed.value()->channel;
    const auto hook = HookOf(channel);
    const auto found =
        hook ? webhooks_.Get(*hook) : core::Result<Webhook>(core::Refuse("no_webhook"));
    const std::lock_guard lock(mutex_);
    busy_.insert(channel);
    if (found.ok() && found.value().account > 0) for_people_.insert(channel);
  }
  return claimed;
}

Attempt Dispatcher::Send(const Message& message) {
  for (Channel* channel : parts_.channels) {
    if (!message.channel.starts_with(channel->prefix())) continue;
    try {
      return channel->Send(message);
    } catch (const std::exception& error) {  // of what a receiver has answered
      return {Outcome::kRefused, error.what()};
    }
  }
  const auto hook = HookOf(message.channel);
  if (!hook) return {Outcome::kNever, "nothing sends to " + message.channel};
  const auto found = webhooks_.Get(*hook);
  if (!found.ok()) {
    const bool gone = found.error().code == core::ErrorCode::kNotFound;
    return {gone ? Outcome::kNever : Outcome::kNotNow, found.error().message};
  }
  Attempt attempt = parts_.hooks.Send(found.value(), message, parts_.clock.Wall());
  const core::Status noted = webhooks_.Note(*hook, attempt.error, parts_.service.Now());
  if (!noted.ok()) Log(noted.error());
  return attempt;
}

milliseconds Dispatcher::Note(const std::string& channel, const Attempt& attempt) {
  const std::lock_guard lock(mutex_);
  if (attempt.outcome != Outcome::kNotNow) {
    rests_.erase(channel);
    if (attempt.pause > milliseconds{0}) {
      rests_[channel] = {0, parts_.clock.Monotonic() + attempt.pause};
    }
    return milliseconds{0};
  }
  Rest& rest = rests_[channel];
  const milliseconds pause = Growing(seconds(1), ++rest.failures, kRestMax);
  rest.until = parts_.clock.Monotonic() + pause;
  return pause;
}

/// The outcome is stored when the database is there again: the claim lasts as long as this
/// membership. A server that stops before leaves the message to be sent again.
void Dispatcher::Store(const Message& message, const Attempt& attempt) {
  const milliseconds rest = Note(message.channel, attempt);
  while (true) {
    const WallTime now = parts_.service.Now();
    core::Status stored = core::Done{};
    switch (attempt.outcome) {
      case Outcome::kTaken:
        stored = outbox_.Delivered(message, now);
        break;
      case Outcome::kNotNow:
        stored = outbox_.Retry(message, attempt.error, now + rest);
        break;
      case Outcome::kRefused:
        stored = outbox_.Retry(
            message, attempt.error, now + Growing(seconds(2), message.attempts, kPauseMax));
        break;
      case Outcome::kNever:
        stored = outbox_.GiveUp(message, attempt.error, now);
        break;
    }
    if (stored.ok() || stored.error().code == core::ErrorCode::kStale) return;
    Log(stored.error());
    std::unique_lock lock(mutex_);
    const auto stopping = [this] { return stopping_; };
    if (parts_.clock.WaitUntil(lock, wake_, parts_.clock.Monotonic() + kStoreAgain, stopping)) {
      return;
    }
  }
}

void Dispatcher::Log(const core::Error& error) {
  parts_.log("outbox: " + error.message);
}

}  // namespace faultlab::server::notify

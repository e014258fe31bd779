#include "server/api/sharing/person_feed.h"

#include <boost/json.hpp>
#include <utility>

#include "server/api/sharing/lists.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

constexpr std::chrono::milliseconds kLook{100};
constexpr std::chrono::hours kChannelLife{12};
constexpr int kNewsPage = 100;

std::string Message(const std::string& holdings, const json::array& news, std::int64_t next) {
  return "{\"type\":\"lab\"," + holdings + ",\"news\":" + json::serialize(news) +
         ",\"next\":" + std::to_string(next) + "}";
}

core::Result<HttpResponse> IssueFeedToken(Api& api, const ApiRequest& request) {
  const std::string channel = api.feed->Open(lab::UserId{request.who.user_id});
  const std::string code = api.tokens.Issue({channel, ViewerOwnerOf(request.who), false});
  return JsonResponse(json::object{{"code", code}, {"expires_in_s", kStreamTokenLife.count()}},
                      201);
}

}  // namespace

PersonFeed::PersonFeed(Api& api)
    : api_(api), looks_(api.clock, Repeated::First::kAfterAPause, kLook, [this] { Look(); }) {}

std::string PersonFeed::Holdings(const lab::LabState& state, lab::UserId user) const {
  return "\"tickets\":" + json::serialize(TicketsOf(state, user, api_.clock.Wall())) +
         ",\"sessions\":" + json::serialize(SessionsOf(api_, state, user)) +
         ",\"bookings\":" + json::serialize(BookingsOf(state, user));
}

std::int64_t PersonFeed::NewestEvent(lab::UserId user) const {
  std::int64_t newest = 0;
  while (true) {
    const auto page = api_.service.EventsSince(user, newest, kNewsPage);
    if (!page.ok() || page.value().empty()) return newest;
    newest = page.value().back().seq;
  }
}

std::string PersonFeed::Open(lab::UserId user) {
  const auto state = api_.service.state();
  const std::lock_guard lock(mutex_);
  Listener& listener = listeners_[user];
  listener.expires = api_.clock.Monotonic() + kChannelLife;
  if (!listener.channel.empty()) return listener.channel;
  listener.channel = "lab:" + std::to_string(lab::Number(user));
  listener.told = Holdings(*state, user);
  listener.next = NewestEvent(user);
  ChannelOptions options;
  options.run = listener.channel;
  options.started = api_.clock.Monotonic();
  options.signals = false;
  api_.hub.OpenChannel(std::move(options), Message(listener.told, {}, listener.next));
  return listener.channel;
}

void PersonFeed::TellAll(const lab::LabState& state) {
  const std::lock_guard lock(mutex_);
  for (auto& [user, listener] : listeners_) {
    std::string holdings = Holdings(state, user);
    const auto events = api_.service.EventsSince(user, listener.next, kNewsPage);
    const bool news = events.ok() && !events.value().empty();
    if (!news && holdings == listener.told) continue;
    listener.told = std::move(holdings);
    if (news) listener.next = events.value().back().seq;
    const json::array told = news ? EventsToJson(api_, events.value()) : json::array();
    api_.hub.PublishText(listener.channel,
                         Message(listener.told, told, listener.next),
                         Message(listener.told, {}, listener.next));
  }
}

void PersonFeed::Look() {
  {
    const std::lock_guard lock(mutex_);
    const MonotonicTime now = api_.clock.Monotonic();
    std::erase_if(listeners_, [&](const auto& each) {
      const bool over = now >= each.second.expires;
      if (over) api_.hub.CloseChannel(each.second.channel, {}, {});
      return over;
    });
  }
  auto state = api_.service.state();
  if (state == last_) return;
  last_ = std::move(state);
  TellAll(*last_);
}

std::span<const ApiRoute> PersonFeedRoutes() {
  using namespace routing;
  static constexpr auto kRoutes = std::to_array<ApiRoute>({
      {kPost, "events/stream-token", kUseTicket, kRole, IssueFeedToken, kEmptyForSecret},
  });
  return kRoutes;
}

}  // namespace faultlab::server

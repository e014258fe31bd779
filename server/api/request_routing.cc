#include "server/api/request_routing.h"

#include <algorithm>
#include <boost/json.hpp>
#include <string>
#include <utility>

#include "server/json/kept_json.h"
#include "server/stream/stream_tokens.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

/// An ended run keeps its channel for its viewers (StreamHubOptions::linger) and a code its life.
constexpr std::chrono::minutes kAfterglow{1};

const json::string* TextMember(const json::object& object, std::string_view name) {
  const json::value* member = object.if_contains(name);
  return member != nullptr ? member->if_string() : nullptr;
}

const json::string* TextMember(const json::value& value, std::string_view name) {
  const json::object* object = value.if_object();
  return object != nullptr ? TextMember(*object, name) : nullptr;
}

/// A run on any simulator: on a free one of this server's, else on a free one of another.
std::string AnySimulator(const lab::LabService& service) {
  const auto state = service.state();
  std::string far;
  std::string busy;
  for (const auto& [id, rig] : state->rigs) {
    if (!rig.elastic || rig.status == lab::RigStatus::kOffline) continue;
    const bool own = rig.server == service.member();
    const bool ready = rig.status == lab::RigStatus::kReady;
    if (own && ready) return id;
    if (ready) far = id;
    if (own) busy = id;
  }
  return far.empty() ? busy : far;
}

json::array ItemsOf(std::string_view body) {
  json::value list = ParsedOr(body);
  json::value* items = list.is_object() ? list.as_object().if_contains("items") : nullptr;
  return items != nullptr && items->is_array() ? std::move(items->as_array()) : json::array();
}

/// A far rig may be heard by several servers: the word of the one that has it counts.
void Add(const lab::LabService& service,
         const std::string& member,
         json::array news,
         json::array& items) {
  for (json::value& item : news) {
    const std::string id = TextIn(item, "id");
    const auto known = std::ranges::find_if(
        items, [&id](const json::value& each) { return TextIn(each, "id") == id; });
    if (known == items.end()) {
      items.push_back(std::move(item));
    } else if (const auto owner = service.MemberOf(id); owner && owner->id == member) {
      *known = std::move(item);
    }
  }
}

}  // namespace

/// This server is a member itself: asking it is answering.
std::optional<AskPeers> RequestRouting::UnlessSelf(const std::optional<lab::Member>& member) const {
  if (!member || member->id == service_.member()) return std::nullopt;
  return AskPeers{{{member->id, member->address}}};
}

std::optional<AskPeers> RequestRouting::AtRunsMember(const RunRecord& run, bool afterglow) const {
  const bool live = run.state == RunState::kRunning ||
                    (afterglow && run.ended_at && clock_.Wall() < *run.ended_at + kAfterglow);
  if (!live || run.source != "run") return std::nullopt;
  return UnlessSelf(service_.MemberWithId(run.server_id));
}

/// What ends or passes on a lease is done where its rig is: there the rig is fenced before anybody
/// is told. A session that another server has just made is looked up in the database.
std::optional<AskPeers> RequestRouting::AtMemberOfSession(const ApiRequest& request) const {
  const auto id = PathNumber(request);
  if (!id) return std::nullopt;
  const auto find = [&]() -> std::optional<lab::RigId> {
    const auto state = service_.state();
    const auto session = state->sessions.find(lab::SessionId{id.value()});
    if (session == state->sessions.end()) return std::nullopt;
    return session->second.rig;
  };
  auto rig = find();
  if (!rig && service_.TickNow().ok()) rig = find();
  return rig ? UnlessSelf(service_.MemberOf(*rig)) : std::nullopt;
}

std::optional<AskPeers> RequestRouting::AtMemberOfBooking(const ApiRequest& request) const {
  const auto id = PathNumber(request);
  if (!id) return std::nullopt;
  const auto state = service_.state();
  const auto booking = state->bookings.find(lab::BookingId{id.value()});
  if (booking == state->bookings.end()) return std::nullopt;
  return UnlessSelf(service_.MemberOf(booking->second.rig));
}

/// Of a run's body, or of a batch of runs whose rigs are all of one member.
std::optional<AskPeers> RequestRouting::AtMemberOfBody(const json::object& body) const {
  const json::value* runs = body.if_contains("runs");
  if (runs == nullptr || !runs->is_array()) {
    if (body.contains("recording")) return std::nullopt;
    const json::string* rig = TextMember(body, "rig");
    const bool any = rig == nullptr || rig->empty();
    return UnlessSelf(service_.MemberOf(any ? AnySimulator(service_) : std::string(*rig)));
  }
  std::optional<lab::Member> common;
  for (const json::value& run : runs->get_array()) {
    const json::string* rig = TextMember(run, "rig");
    if (rig == nullptr) continue;
    auto member = service_.MemberOf(std::string(*rig));
    if (!member || (common && common->id != member->id)) return std::nullopt;
    common = std::move(member);
  }
  return UnlessSelf(common);
}

std::optional<AskPeers> RequestRouting::AnsweredElsewhere(LivesAt lives_at,
                                                          const ApiRequest& request) const {
  if (service_.Others().empty()) return std::nullopt;
  switch (lives_at) {
    case LivesAt::kAnywhere:
    case LivesAt::kEveryMember:
      return std::nullopt;
    case LivesAt::kRunsMember:
      return AtRunsMember(request.run, false);
    case LivesAt::kRunsViewers:
      return AtRunsMember(request.run, true);
    case LivesAt::kRigsMember:
      return UnlessSelf(service_.MemberOf(request.http.PathParameter("id")));
    case LivesAt::kSessionsMember:
      return AtMemberOfSession(request);
    case LivesAt::kBookingsMember:
      return AtMemberOfBooking(request);
    case LivesAt::kBodysRig:
      return AtMemberOfBody(request.body);
  }
  return std::nullopt;
}

RouteAnswer RequestRouting::JoinedWithOthers(HttpResponse own) const {
  if (own.status != 200) return own;
  AskPeers ask;
  for (const lab::Member& member : service_.Others()) {
    if (!member.address.empty()) ask.peers.push_back({member.id, member.address});
  }
  if (ask.peers.empty()) return own;
  ask.join = [&service = service_, peers = ask.peers, own = std::move(own)](
                 std::vector<core::Result<HttpResponse>> answers) {
    json::array items = ItemsOf(own.body);
    for (std::size_t i = 0; i < answers.size(); ++i) {
      // Who does not answer has no rig that anybody could use now.
      if (!answers[i].ok() || answers[i].value().status != 200) continue;
      Add(service, peers[i].name, ItemsOf(answers[i].value().body), items);
    }
    return JsonResponse(json::object{{"items", std::move(items)}});
  };
  return ask;
}

std::optional<PeerAddress> RequestRouting::MemberOfCode(std::string_view code) const {
  const std::string issuer(StreamTokens::IssuerOf(code));
  const auto member = service_.MemberWithId(issuer);
  if (!member || member->id == service_.member()) return std::nullopt;
  return PeerAddress{member->id, member->address};
}

}  // namespace faultlab::server

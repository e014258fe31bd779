#include "server/api/whereabouts.h"

#include <algorithm>
#include <boost/json.hpp>
#include <string>
#include <utility>

#include "server/api/lab/handlers.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

/// An ended run keeps its channel for its viewers (StreamHubOptions::linger) and a code its life.
constexpr std::chrono::minutes kAfterglow{1};

AskPeers Ask(const lab::Member& member) {
  return {{{member.id, member.address}}};
}

/// This server is a member itself: asking it is answering.
std::optional<AskPeers> UnlessSelf(const ApiContext& api,
                                   const std::optional<lab::Member>& member) {
  if (!member || member->id == api.lab->service.member()) return std::nullopt;
  return Ask(*member);
}

std::optional<AskPeers> AtRunsMember(ApiContext& api, const HttpRequest& http, bool afterglow) {
  const auto record = api.store.Get(http.PathParameter("id"));
  if (!record.ok()) return std::nullopt;
  const bool live = record.value().state == RunState::kRunning ||
                    (afterglow && record.value().ended_at &&
                     api.clock.Wall() < *record.value().ended_at + kAfterglow);
  if (!live || record.value().source != "run") return std::nullopt;
  return UnlessSelf(api, api.lab->service.MemberWithId(record.value().server_id));
}

const json::string* TextMember(const json::value& value, std::string_view name) {
  const json::object* object = value.if_object();
  const json::value* member = object != nullptr ? object->if_contains(name) : nullptr;
  return member != nullptr ? member->if_string() : nullptr;
}

/// A run on any simulator: on one of this server's, or of one that has any.
std::string AnySimulator(const lab::LabService& service) {
  const auto state = service.state();
  std::string far;
  for (const auto& [id, rig] : state->rigs) {
    if (!rig.elastic || rig.status == lab::RigStatus::kOffline) continue;
    if (rig.server == service.member()) return id;
    far = id;
  }
  return far;
}

/// Of a run's body, or of a batch of runs whose rigs are all of one member.
std::optional<AskPeers> AtMemberOfBody(ApiContext& api, const HttpRequest& http) {
  const lab::LabService& service = api.lab->service;
  boost::system::error_code ec;
  const json::value body = json::parse(http.body, ec);
  if (ec || !body.is_object()) return std::nullopt;
  const json::value* runs = body.as_object().if_contains("runs");
  if (runs == nullptr || !runs->is_array()) {
    if (body.as_object().contains("recording")) return std::nullopt;
    const json::string* rig = TextMember(body, "rig");
    const bool any = rig == nullptr || rig->empty();
    return UnlessSelf(api, service.MemberOf(any ? AnySimulator(service) : std::string(*rig)));
  }
  std::optional<lab::Member> common;
  for (const json::value& run : runs->as_array()) {
    const json::string* rig = TextMember(run, "rig");
    if (rig == nullptr) continue;
    auto member = service.MemberOf(std::string(*rig));
    if (!member || (common && common->id != member->id)) return std::nullopt;
    common = std::move(member);
  }
  return UnlessSelf(api, common);
}

json::array ItemsOf(std::string_view body) {
  boost::system::error_code ec;
  json::value list = json::parse(body, ec);
  json::value* items = !ec && list.is_object() ? list.as_object().if_contains("items") : nullptr;
  return items != nullptr && items->is_array() ? std::move(items->as_array()) : json::array();
}

std::string IdOf(const json::value& item) {
  const json::string* id = TextMember(item, "id");
  return id != nullptr ? std::string(*id) : std::string();
}

/// A far rig may be heard by several servers: the word of the one that has it counts.
void Add(const lab::LabService& service,
         const std::string& member,
         json::array news,
         json::array& items) {
  for (json::value& item : news) {
    const std::string id = IdOf(item);
    const auto known = std::find_if(
        items.begin(), items.end(), [&id](const json::value& each) { return IdOf(each) == id; });
    if (known == items.end()) {
      items.push_back(std::move(item));
    } else if (const auto owner = service.MemberOf(id); owner && owner->id == member) {
      *known = std::move(item);
    }
  }
}

}  // namespace

std::optional<AskPeers> AnsweredElsewhere(ApiContext& api,
                                          const ApiRoute& route,
                                          const HttpRequest& http) {
  if (api.lab == nullptr || api.lab->service.Others().empty()) return std::nullopt;
  switch (route.lives_at) {
    case LivesAt::kAnywhere:
    case LivesAt::kEveryMember:
      return std::nullopt;
    case LivesAt::kRunsMember:
      return AtRunsMember(api, http, false);
    case LivesAt::kRunsViewers:
      return AtRunsMember(api, http, true);
    case LivesAt::kRigsMember:
      return UnlessSelf(api, api.lab->service.MemberOf(http.PathParameter("id")));
    case LivesAt::kBodysRig:
      return AtMemberOfBody(api, http);
  }
  return std::nullopt;
}

RouteAnswer JoinedWithOthers(ApiContext& api, HttpResponse own) {
  if (api.lab == nullptr || own.status != 200) return own;
  AskPeers ask;
  for (const lab::Member& member : api.lab->service.Others()) {
    if (!member.address.empty()) ask.peers.push_back({member.id, member.address});
  }
  if (ask.peers.empty()) return own;
  ask.join = [&service = api.lab->service, peers = ask.peers, own = std::move(own)](
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

std::optional<PeerAddress> MemberOfCode(const ApiContext& api, std::string_view code) {
  if (api.lab == nullptr) return std::nullopt;
  const std::string issuer(StreamTokens::IssuerOf(code));
  const auto member = api.lab->service.MemberWithId(issuer);
  if (!member || member->id == api.lab->service.member()) return std::nullopt;
  return PeerAddress{member->id, member->address};
}

core::Status RigIsKnown(ApiContext& api, const std::string& rig) {
  if (api.lab != nullptr && api.lab->service.state()->rigs.contains(rig)) return core::Done{};
  const auto found = api.bay.Find(rig);
  if (!found) return found.error();
  return core::Done{};
}

}  // namespace faultlab::server

#include "server/app/viewer_watch.h"

#include <chrono>
#include <utility>
#include <vector>

#include "server/auth/authorization.h"
#include "server/wall_time.h"

namespace faultlab::server {
namespace {

constexpr std::chrono::seconds kLookEvery{2};

Principal PrincipalOf(const ViewerOwner& owner) {
  Principal who;
  who.user_id = owner.account_id;
  who.session_token_hash = owner.sign_in;
  who.api_key_id = owner.api_key_id;
  who.proof = owner.api_key_id != 0 ? Proof::kApiKey : Proof::kSessionCookie;
  who.role = ParseRole(owner.role).value_or(Role::kGuest);
  return who;
}

}  // namespace

ViewerWatch::ViewerWatch(Accounts& accounts,
                         StreamHub& hub,
                         StreamTokens& tokens,
                         const Clock& clock)
    : accounts_(accounts), hub_(hub), tokens_(tokens), clock_(clock) {
  accounts_.SetOnRevoked([this](const Revocation& revocation) { End(revocation); });
  looks_.emplace(clock_, Repeated::First::kAfterAPause, kLookEvery, [this] { Look(); });
}

ViewerWatch::~ViewerWatch() {
  looks_.reset();
  accounts_.SetOnRevoked({});
}

void ViewerWatch::End(const Revocation& revocation) {
  const bool course = revocation.what == Revocation::What::kCourse;
  const auto ended = [revocation, course](const ViewerOwner& owner) {
    // It is not known here whose student it was; a teacher who may still watch connects again.
    return (course && owner.foreign()) || Ends(revocation, PrincipalOf(owner));
  };
  tokens_.Drop(ended);
  hub_.CloseOf(ended);
}

void ViewerWatch::Look() {
  std::vector<ViewerOwner> owners = hub_.Owners();
  for (ViewerOwner& owner : tokens_.Owners()) owners.push_back(std::move(owner));
  for (const ViewerOwner& owner : owners) {
    if (owner.account_id == 0 || MayWatch(owner)) continue;
    const auto same = [owner](const ViewerOwner& other) { return other == owner; };
    tokens_.Drop(same);
    hub_.CloseOf(same);
  }
}

bool ViewerWatch::MayWatch(const ViewerOwner& owner) {
  const Principal who = PrincipalOf(owner);
  const auto holds = accounts_.Holds(who, clock_.Wall());
  if (!holds.ok()) return true;  // if the database is away, views stay open
  if (!holds.value()) return false;
  if (!owner.foreign()) return true;
  const auto whose =
      accounts_.RelationTo(who, owner.run_owner, FromMilliseconds(owner.run_made_ms));
  return !whose.ok() || Allowed(who.role, Operation::kReadRun, whose.value());
}

}  // namespace faultlab::server

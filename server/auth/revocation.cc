#include "server/auth/revocation.h"

namespace faultlab::server {

bool Ends(const Revocation& revocation, const Principal& who) {
  using enum Revocation::What;
  if (!who.signed_in() || who.user_id != revocation.account_id) return false;
  const bool by_key = who.proof == Proof::kApiKey;
  switch (revocation.what) {
    case kEverything:
    case kCourse:
      return true;
    case kOtherSignIns:
      return !by_key && who.session_token_hash != revocation.sign_in;
    case kSignIn:
      return !by_key && who.session_token_hash == revocation.sign_in;
    case kApiKeys:
      return by_key;
    case kApiKey:
      return by_key && who.api_key_id == revocation.api_key_id;
  }
  return true;
}

}  // namespace faultlab::server

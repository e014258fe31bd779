#pragma once

#include <string>

#include "server/auth/principal.h"
#include "server/wall_time.h"

namespace faultlab::server {

/// A person authenticated by a sign-in provider, identified only by issuer and subject.
struct VouchedPerson {
  std::string issuer;
  std::string subject;
  std::string login;  ///< proposed login, if an account is made
  std::string name;   ///< for display; may be empty
  std::string state;  ///< of this one sign-in: it is accepted only once
};

/// What happens with a person without an account here.
struct NewcomerRules {
  bool make_accounts = true;
  /// Accounts of students without a password, to which nobody ever signed in, are given to the
  /// first person with their login.
  bool claim_class_list = false;
  Role role = Role::kStudent;  ///< of an account that is made
  bool staff = true;           ///< accounts of operators and admins are let in, too
  std::string other_login{};  ///< of it, where the proposed one is none or is taken; empty: refused
};

/// Somebody of a course elsewhere, as a learning platform tells; `person.state` is empty.
struct RosterPerson {
  VouchedPerson person;
  NewcomerRules rules;
};

struct LinkedIdentity {
  std::string issuer;
  WallTime at{};
};

}  // namespace faultlab::server

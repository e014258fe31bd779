#pragma once

#include <boost/json/object.hpp>
#include <string>
#include <string_view>

#include "core/types/result.h"
#include "server/oidc/provider_settings.h"

namespace faultlab::server::oidc {

/// A person as the provider knows them.
struct Person {
  std::string issuer;
  std::string subject;  ///< never given to somebody else by this issuer
  std::string login;    ///< proposed; empty if the provider gives none
  std::string name;     ///< for display; empty if the provider gives none
};

/// A text claim; empty when there is none, or it is no text.
std::string TextOf(const boost::json::object& claims, std::string_view name);

/// kForbidden, with what is missing, for people whom the rules do not let in.
core::Result<Person> Admit(const boost::json::object& claims, const AdmissionRules& rules);

}  // namespace faultlab::server::oidc

#pragma once

#include <boost/json/object.hpp>
#include <string>
#include <string_view>

#include "core/types/result.h"
#include "server/oidc/provider_settings.h"

namespace faultlab::server::oidc {

/// A person as described by the provider.
struct Person {
  std::string issuer;
  std::string subject;  ///< this issuer never gives it to another person
  std::string login;    ///< proposed; empty if the provider gives none
  std::string name;     ///< for display; empty if the provider gives none
};

/// A text claim; empty if it is absent or not a text.
std::string TextOf(const boost::json::object& claims, std::string_view name);

/// kForbidden, with what is missing, for people who are not admitted by the rules.
core::Result<Person> Admit(const boost::json::object& claims, const AdmissionRules& rules);

}  // namespace faultlab::server::oidc

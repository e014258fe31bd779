#include "server/oidc/claims.h"

#include <algorithm>
#include <boost/json.hpp>

namespace faultlab::server::oidc {
namespace {

namespace json = boost::json;

constexpr std::size_t kNameBytesMax = 200;

core::Error NotAllowed(const std::string& what) {
  return {core::ErrorCode::kForbidden, what, ""};
}

bool IsTrue(const json::object& claims, std::string_view name) {
  const json::value* value = claims.if_contains(name);
  if (value == nullptr) return false;
  return value->is_bool() ? value->get_bool() : TextOf(claims, name) == "true";
}

std::string Lower(std::string text) {
  std::ranges::transform(text, text.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  return text;
}

bool DomainIsAllowed(const std::string& email, const std::vector<std::string>& domains) {
  const std::size_t at = email.rfind('@');
  if (at == std::string::npos || email.find('@') != at) return false;
  const std::string domain = Lower(email.substr(at + 1));
  return std::ranges::any_of(domains,
                             [&](const std::string& allowed) { return Lower(allowed) == domain; });
}

bool Has(const json::object& claims, const std::string& required) {
  const std::size_t equals = required.find('=');
  if (equals == std::string::npos) return false;
  const std::string wanted = required.substr(equals + 1);
  const json::value* value = claims.if_contains(required.substr(0, equals));
  if (value == nullptr) return false;
  if (value->is_string()) return value->get_string() == wanted;
  if (!value->is_array()) return false;
  const json::array& list = value->get_array();
  return std::ranges::any_of(
      list, [&](const json::value& one) { return one.is_string() && one.get_string() == wanted; });
}

}  // namespace

std::string TextOf(const json::object& claims, std::string_view name) {
  const json::value* value = claims.if_contains(name);
  return value != nullptr && value->is_string() ? std::string(value->get_string()) : "";
}

core::Result<Person> Admit(const json::object& claims, const AdmissionRules& rules) {
  if (!rules.allowed_domains.empty()) {
    if (!IsTrue(claims, "email_verified")) return NotAllowed("the e-mail address is not verified");
    if (!DomainIsAllowed(TextOf(claims, "email"), rules.allowed_domains)) {
      return NotAllowed("the e-mail address is of another domain");
    }
  }
  if (!rules.required_claim.empty() && !Has(claims, rules.required_claim)) {
    return NotAllowed("the claim " + rules.required_claim + " is missing");
  }
  Person person;
  person.issuer = TextOf(claims, "iss");
  person.subject = TextOf(claims, "sub");
  person.login = TextOf(claims, rules.login_claim);
  if (rules.login_claim == "email" && !IsTrue(claims, "email_verified")) person.login.clear();
  person.name = TextOf(claims, "name");
  if (person.name.size() > kNameBytesMax) person.name.clear();
  return person;
}

}  // namespace faultlab::server::oidc

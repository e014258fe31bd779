#pragma once

#include <string>
#include <vector>

namespace faultlab::server::oidc {

/// Which people of a provider are admitted, and with which login.
struct AdmissionRules {
  std::string login_claim = "preferred_username";
  std::vector<std::string> allowed_domains;  ///< of a verified e-mail address; empty: all
  std::string required_claim;                ///< "name=value"; the claim may be a list; empty: none
};

/// One provider, as configured by the operator ([[oidc]] of the configuration).
struct ProviderSettings {
  std::string id;     ///< used in this server's addresses: "uni"
  std::string label;  ///< on the button: "University of Novi Sad"
  std::string issuer;
  std::string client_id;
  std::string client_secret;  ///< empty: a public client, with PKCE only
  std::vector<std::string> scopes = {"openid", "profile", "email"};
  AdmissionRules admission;
  bool make_accounts = true;  ///< for people who have no account
  /// Accounts without a password that a class list made are given to the first person with their
  /// login: safe only if people cannot choose the login claim.
  bool claim_class_list = false;
  std::string ca_file;
  bool insecure_loopback = false;
};

}  // namespace faultlab::server::oidc

#pragma once

#include <string>
#include <vector>

namespace faultlab::server::oidc {

/// Which people of a provider may come in, and as whom.
struct AdmissionRules {
  std::string login_claim = "preferred_username";
  std::vector<std::string> allowed_domains;  ///< of a verified e-mail address; empty: all
  std::string required_claim;                ///< "name=value"; the claim may be a list; empty: none
};

/// One place where people sign in, as the operator names it ([[oidc]] of the configuration).
struct ProviderSettings {
  std::string id;     ///< in addresses of ours: "uni"
  std::string label;  ///< on the button: "University of Novi Sad"
  std::string issuer;
  std::string client_id;
  std::string client_secret;  ///< empty: a public client, with PKCE alone
  std::vector<std::string> scopes = {"openid", "profile", "email"};
  AdmissionRules admission;
  bool make_accounts = true;  ///< for people who have none
  /// Accounts without a password that a class list made are given to the first person with their
  /// login: right only where nobody can choose the login claim.
  bool claim_class_list = false;
  std::string ca_file;
  bool insecure_loopback = false;
};

}  // namespace faultlab::server::oidc

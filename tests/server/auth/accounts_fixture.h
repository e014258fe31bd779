#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <string>

#include "server/auth/accounts.h"
#include "tests/support/engines.h"
#include "tests/support/test_database.h"

namespace faultlab::server {

inline constexpr WallTime kNow{std::chrono::milliseconds{1'770'000'000'000}};
inline const std::string kPassword = "correct horse battery";

/// Accounts on an empty database of either engine.
class AccountsTest : public testing::TestWithParam<Engine> {
 protected:
  Account Person(const std::string& login, Role role, bool password = false) {
    const auto account = accounts_.Create(login, "Ünï 名 " + login, role, kNow);
    EXPECT_TRUE(account.ok());
    if (password) {
      const auto link = accounts_.CreateLink(account.value().id, kNow);
      EXPECT_TRUE(accounts_.UseLink(link.value(), kPassword, kNow).ok());
    }
    return account.value();
  }
  static Principal As(const Account& account) {
    Principal who;
    who.user_id = account.id;
    who.login = account.login;
    who.role = account.role;
    return who;
  }
  core::Result<SignedIn> SignIn(const std::string& login,
                                const std::string& password,
                                WallTime now = kNow) {
    return accounts_.SignIn({login, password, "192.0.2.1", ""}, now).signed_in;
  }
  RequestCredentials WithCookie(const std::string& secret) {
    cookie_ = "a=b; faultlab_session=" + secret + "; c=d";
    RequestCredentials credentials;
    credentials.cookie = cookie_;
    credentials.remote_address = "192.0.2.1";
    credentials.host = "lab.example";
    return credentials;
  }
  tests::TestDatabase database_{GetParam()};
  Accounts accounts_{*database_, GuestAccess::kLoopback, PasswordCost::kLeast};
  std::string cookie_;
};

}  // namespace faultlab::server

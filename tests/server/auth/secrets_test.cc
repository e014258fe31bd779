#include "server/auth/secrets.h"

#include <gtest/gtest.h>

namespace faultlab::server {
namespace {

TEST(PasswordHasherTest, UnlessItIsToldAGuessCostsMemoryAndTime) {
  PasswordHasher hasher;
  const std::string hash = hasher.Hash("correct horse battery").value();
  EXPECT_TRUE(hash.starts_with("$argon2id$v=19$m=65536,t=2,p=1$")) << hash;
  EXPECT_TRUE(hasher.Verify(hash, "correct horse battery").value());
  EXPECT_FALSE(hasher.Verify(hash, "correct horse batterx").value());
}

TEST(PasswordHasherTest, ChecksWhatWasHashedAtAnotherCost) {
  PasswordHasher cheap(PasswordCost::kLeast);
  const std::string hash = cheap.Hash("correct horse battery").value();
  EXPECT_TRUE(PasswordHasher().Verify(hash, "correct horse battery").value());
  EXPECT_FALSE(PasswordHasher().Verify("", "correct horse battery").value()) << "no such account";
}

}  // namespace
}  // namespace faultlab::server

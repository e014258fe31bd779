#include "server/auth/sign_in_limits.h"

#include <gmock/gmock.h>

namespace faultlab::server {
namespace {

using core::ErrorCode;
using std::chrono::hours;
using std::chrono::minutes;
using std::chrono::seconds;

constexpr WallTime kNow{std::chrono::milliseconds{1'770'000'000'000}};
const std::string kHome = "192.0.2.1";

/// The number of tries until one is refused.
int TriesUntilRefused(SignInLimits& limits,
                      const std::string& account,
                      const std::string& address,
                      const std::string& device = "") {
  int tries = 0;
  while (tries < 1000 && limits.Begin({account, address, device}, kNow).ok()) ++tries;
  return tries;
}

TEST(SignInLimits, AStrangerSlowsDownOnlyHisOwnTries) {
  SignInLimits limits;
  EXPECT_EQ(TriesUntilRefused(limits, "ann", "198.51.100.7"), 5);
  EXPECT_TRUE(limits.Begin({"ann", kHome}, kNow).ok()) << "the owner is somewhere else";
}

TEST(SignInLimits, ManyNetworksHaveNoMoreTriesThanFewAndDoNotLockTheOwnerOut) {
  SignInLimits limits;
  int tries = 0;
  for (int i = 0; i < 100; ++i) {
    tries += TriesUntilRefused(limits, "ann", "198.51.100." + std::to_string(i));
  }
  EXPECT_EQ(tries, 30) << "the account as a whole, from however many networks";
  EXPECT_EQ(TriesUntilRefused(limits, "bob", kHome) + TriesUntilRefused(limits, "eve", kHome) +
                TriesUntilRefused(limits, "cem", kHome) + TriesUntilRefused(limits, "dan", kHome) +
                TriesUntilRefused(limits, "eva", kHome),
            20 + 1)
      << "the network of the owner as a whole, and one of each further account";
  EXPECT_EQ(limits.Begin({"ann", "203.0.113.9"}, kNow).error().code, ErrorCode::kTooMany);
  const SignInLimits::Attempt at_home{"ann", "192.0.2.2", "", true};
  for (int typo = 0; typo < 5; ++typo) {
    EXPECT_TRUE(limits.Begin(at_home, kNow).ok()) << "from where she has signed in before";
  }
  EXPECT_TRUE(limits.Begin({"ann", kHome, "her laptop"}, kNow).ok());
}

TEST(SignInLimits, AKnownDeviceMayGuessNoMoreThanAnybodyElse) {
  SignInLimits limits;
  EXPECT_EQ(TriesUntilRefused(limits, "ann", kHome, "her laptop"), 10)
      << "5 of the device, then 5 of account and network";
}

TEST(SignInLimits, ARefusalSaysWhenToComeBack) {
  SignInLimits limits;
  TriesUntilRefused(limits, "ann", kHome);
  const core::Error refused = limits.Begin({"ann", kHome}, kNow).error();
  EXPECT_EQ(refused.reason, "sign_in_throttled");
  ASSERT_EQ(refused.parameters.size(), 1u);
  EXPECT_EQ(refused.parameters[0].name, "seconds");
  EXPECT_EQ(refused.parameters[0].value, "1");
  EXPECT_TRUE(limits.Begin({"ann", kHome}, kNow + seconds(1)).ok());
  EXPECT_EQ(limits.Begin({"ann", kHome}, kNow + seconds(2)).error().parameters[0].value, "1");
  EXPECT_TRUE(limits.Begin({"ann", kHome}, kNow + seconds(2) + hours(1)).ok()) << "forgotten";
  EXPECT_TRUE(limits.Begin({"ann", kHome}, kNow + seconds(3) + hours(1)).ok());
}

TEST(SignInLimits, RefusedTriesAreNotCounted) {
  SignInLimits limits;
  TriesUntilRefused(limits, "ann", kHome);
  for (int i = 0; i < 100; ++i) EXPECT_FALSE(limits.Begin({"ann", kHome}, kNow).ok());
  for (const char* other : {"bob", "cem", "dan"}) {
    EXPECT_EQ(TriesUntilRefused(limits, other, kHome), 5) << "the network has 15 of 20 left";
  }
}

TEST(SignInLimits, ASuccessForgivesItselfAndTheOwnersMistakesButNotWhatOthersDid) {
  SignInLimits limits;
  for (int i = 0; i < 4; ++i) ASSERT_TRUE(limits.Begin({"ann", kHome}, kNow).ok());
  auto right = limits.Begin({"ann", kHome}, kNow);
  ASSERT_TRUE(right.ok());
  right.value().Succeeded();
  EXPECT_EQ(TriesUntilRefused(limits, "ann", kHome), 5);
  // 4 + 5 of the 20 of the network are used: a person with an account cannot guess without limit.
  EXPECT_EQ(TriesUntilRefused(limits, "bob", kHome) + TriesUntilRefused(limits, "cem", kHome) +
                TriesUntilRefused(limits, "dan", kHome),
            11);
}

TEST(SignInLimits, WhatNobodyJudgedIsNoFailure) {
  SignInLimits limits;
  for (int i = 0; i < 50; ++i) {
    auto pass = limits.Begin({"ann", kHome}, kNow);
    ASSERT_TRUE(pass.ok()) << i;
    pass.value().NotJudged();
  }
}

TEST(SignInLimits, AHostCannotChangeItsAddressWithinItsNetwork) {
  SignInLimits limits;
  EXPECT_EQ(TriesUntilRefused(limits, "ann", "2001:db8::1"), 5);
  EXPECT_EQ(TriesUntilRefused(limits, "ann", "2001:db8::2"), 0);
}

TEST(Throttle, AClockSetBackLocksNobodyOutForLong) {
  Throttle throttle(1);
  ASSERT_TRUE(throttle.Try("a", kNow).ok());
  EXPECT_FALSE(throttle.Try("a", kNow - minutes(14)).ok()) << "one failure is still one";
  EXPECT_TRUE(throttle.Try("a", kNow - hours(24)).ok());
}

TEST(Throttle, TheWaitDoublesUpToAQuarterOfAnHour) {
  Throttle throttle(5);
  WallTime now = kNow;
  std::string wait;
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(throttle.Try("a", now).ok()) << i;
    const core::Status again = throttle.Try("a", now);
    if (again.ok()) continue;
    wait = again.error().parameters[0].value;
    now += seconds(std::stoi(wait));
  }
  EXPECT_EQ(wait, "900");
}

}  // namespace
}  // namespace faultlab::server

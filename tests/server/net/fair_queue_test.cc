#include "server/net/fair_queue.h"

#include <gtest/gtest.h>

#include "server/address_key.h"
#include "server/net/trusted_proxies.h"

namespace faultlab::server {
namespace {

TEST(FairQueue, CallersTakeTurnsWhateverOneOfThemHasPutIn) {
  FairQueue<int> queue;
  for (int i = 0; i < 3; ++i) queue.Push("greedy", i);
  queue.Push("one", 10);
  queue.Push("other", 20);
  EXPECT_EQ(queue.SizeOf("greedy"), 3u);
  EXPECT_EQ(queue.size(), 5u);
  for (const int expected : {0, 10, 20, 1, 2}) EXPECT_EQ(queue.Pop(), expected);
  EXPECT_EQ(queue.Pop(), std::nullopt);
  EXPECT_EQ(queue.SizeOf("greedy"), 0u);
}

TEST(FairQueue, ACallerWhoComesBackStandsBehindTheOthers) {
  FairQueue<int> queue;
  queue.Push("a", 1);
  queue.Push("b", 2);
  EXPECT_EQ(queue.Pop(), 1);
  queue.Push("a", 3);
  EXPECT_EQ(queue.Pop(), 2);
  EXPECT_EQ(queue.Pop(), 3);
}

TEST(AddressKeyOf, CountsANetworkOfIpv6AsOneCaller) {
  EXPECT_EQ(AddressKey("203.0.113.9"), "203.0.113.9");
  EXPECT_EQ(AddressKey("2001:db8:1:2:3:4:5:6"), "2001:db8:1:2::/64");
  EXPECT_EQ(AddressKey("2001:db8:1:2::9"), AddressKey("2001:db8:1:2:ffff::1"));
  EXPECT_NE(AddressKey("2001:db8:1:3::9"), AddressKey("2001:db8:1:2::9"));
  EXPECT_EQ(AddressKey("::ffff:203.0.113.9"), "203.0.113.9");
  EXPECT_EQ(AddressKey("fe80::1%eth0"), "fe80::/64");
  EXPECT_EQ(AddressKey("unix"), "unix");
}

TEST(TrustedProxiesOf, KnowsAddressesAndNetworks) {
  const auto parsed = TrustedProxies::Parse({"10.0.0.2", "172.16.0.0/12", "2001:db8::/32"});
  ASSERT_TRUE(parsed.ok());
  const TrustedProxies& proxies = parsed.value();
  for (const char* in : {"10.0.0.2", "::ffff:10.0.0.2", "172.31.255.255", "2001:db8:9::1"}) {
    EXPECT_TRUE(proxies.Has(in)) << in;
  }
  for (const char* out : {"10.0.0.3", "172.32.0.0", "2001:db9::1", "", "word", "127.0.0.1"}) {
    EXPECT_FALSE(proxies.Has(out)) << out;
  }
  EXPECT_FALSE(TrustedProxies().Has("10.0.0.2"));
  EXPECT_TRUE(TrustedProxies::Parse({"0.0.0.0/0"}).value().Has("8.8.8.8"));
  EXPECT_FALSE(TrustedProxies::Parse({"0.0.0.0/0"}).value().Has("2001:db8::1"));
}

TEST(TrustedProxiesOf, NamesWhatIsNoNetwork) {
  for (const char* text : {"proxy", "10.0.0.2/33", "10.0.0.2/", "10.0.0.2/8x", "::/129", ""}) {
    const auto parsed = TrustedProxies::Parse({"10.0.0.1", text});
    ASSERT_FALSE(parsed.ok()) << text;
    EXPECT_NE(parsed.error().message.find("'" + std::string(text) + "'"), std::string::npos);
  }
}

}  // namespace
}  // namespace faultlab::server

#include "server/net/listen_address.h"

#include <gtest/gtest.h>

namespace faultlab::server {
namespace {

TEST(ListenAddress, UnderstandsHostAndPort) {
  const auto v4 = ParseListenAddress("127.0.0.1:8080");
  ASSERT_TRUE(v4.ok());
  EXPECT_EQ(v4.value().host, "127.0.0.1");
  EXPECT_EQ(v4.value().port, 8080);
  const auto v6 = ParseListenAddress("[::1]:0");
  ASSERT_TRUE(v6.ok());
  EXPECT_EQ(v6.value().host, "::1");
  EXPECT_EQ(v6.value().port, 0);
  EXPECT_EQ(ParseListenAddress("localhost:1").value().host, "127.0.0.1");
  EXPECT_EQ(ParseListenAddress(":80").value().host, "0.0.0.0");
  EXPECT_EQ(ParseListenAddress("8080").value().host, "127.0.0.1");
}

TEST(ListenAddress, RefusesWhatIsNoAddress) {
  for (const char* text : {"", "x:1", "127.0.0.1:", "127.0.0.1:70000", "127.0.0.1:80x", "::1:y"}) {
    const auto parsed = ParseListenAddress(text);
    ASSERT_FALSE(parsed.ok()) << text;
    EXPECT_NE(parsed.error().message.find("HOST:PORT"), std::string::npos) << text;
  }
}

TEST(HostAllowed, LetsLiteralsAndLocalhostPassOnLoopback) {
  for (const char* host : {"localhost", "localhost:8080", "127.0.0.1:1", "[::1]:8080", "[::1]"}) {
    EXPECT_TRUE(HostAllowed(host, {}, true)) << host;
  }
}

TEST(HostAllowed, RefusesAForeignNameThatPointsHere) {
  EXPECT_FALSE(HostAllowed("evil.example", {}, true));
  EXPECT_FALSE(HostAllowed("evil.example:8080", {"lab.example"}, false));
  EXPECT_FALSE(HostAllowed("", {}, true));
  EXPECT_TRUE(HostAllowed("lab.example:8080", {"lab.example"}, true));
  EXPECT_TRUE(HostAllowed("any.example", {}, false));
}

TEST(HostAllowed, ReadsANameToItsEnd) {
  for (const char* host : {"[1.2.3.4].evil.example",
                           "[::1]evil",
                           "[::1]:",
                           "[::1]:80x",
                           "[::1",
                           "[]",
                           "[evil.example]",
                           "lab.example:x",
                           "lab.example:80:90",
                           "lab.example:",
                           "localhost:evil",
                           "127.0.0.1:8080.evil.example",
                           "me@lab.example",
                           "lab.example/x",
                           ":8080"}) {
    EXPECT_FALSE(HostAllowed(host, {"lab.example"}, false)) << host;
    EXPECT_FALSE(HostAllowed(host, {}, false)) << host << ", where every name may come";
  }
  EXPECT_TRUE(HostAllowed("[2001:db8::1]:65535", {}, true));
  EXPECT_TRUE(HostAllowed("rig_host-2.example:8080", {}, false));
  EXPECT_TRUE(HostAllowed("", {}, false)) << "HTTP/1.0 names none";
}

TEST(OriginAllowed, AsksForTheSameHostAndPort) {
  EXPECT_TRUE(OriginAllowed("", "localhost:8080"));
  EXPECT_TRUE(OriginAllowed("http://localhost:8080", "localhost:8080"));
  EXPECT_TRUE(OriginAllowed("https://lab.example", "lab.example"));
  EXPECT_FALSE(OriginAllowed("http://localhost:9090", "localhost:8080"));
  EXPECT_FALSE(OriginAllowed("http://evil.example", "localhost:8080"));
  EXPECT_FALSE(OriginAllowed("null", "localhost:8080"));
}

TEST(LoopbackHost, KnowsTheWholeNetwork) {
  EXPECT_TRUE(IsLoopbackHost("127.8.9.1"));
  EXPECT_TRUE(IsLoopbackHost("::1"));
  EXPECT_FALSE(IsLoopbackHost("128.0.0.1"));
  EXPECT_FALSE(IsLoopbackHost("0.0.0.0"));
}

}  // namespace
}  // namespace faultlab::server

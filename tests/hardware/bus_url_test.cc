#include "hardware/lcm/bus_url.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>

#include <string>

#include "hardware/lcm/lcm_tap.h"
#include "hardware/lcm/message_bus.h"

namespace faultlab::hardware {
namespace {

TEST(BusUrl, HasThePartsOfAUdpmUrl) {
  const auto url = ParseUdpmUrl("udpm://239.1.2.3:7700?ttl=1&recv_buf_size=65536").value();
  EXPECT_STREQ(inet_ntoa(url.group), "239.1.2.3");
  EXPECT_EQ(url.port, 7700);
  EXPECT_EQ(url.ttl, 1);
  EXPECT_EQ(url.receive_bytes, 65536);
}

TEST(BusUrl, HasLcmsGroupAndPortByDefaultAndStaysOnThisMachine) {
  for (const char* text : {"udpm://", "udpm://?", "udpm://239.255.76.67", "udpm://:7667"}) {
    const auto url = ParseUdpmUrl(text).value();
    EXPECT_STREQ(inet_ntoa(url.group), "239.255.76.67") << text;
    EXPECT_EQ(url.port, 7667) << text;
    EXPECT_EQ(url.ttl, 0) << text;
    EXPECT_EQ(url.receive_bytes, 4'000'000) << text;
  }
}

TEST(BusUrl, OfAnotherFormIsRefusedByTapAndBus) {
  for (const char* text : {"",
                           "nonsense://",
                           "UDPM://",
                           "tcpq://localhost:7700",
                           "mpudpm://239.255.76.67:7667",
                           "udpm://10.0.0.1:7667",
                           "udpm://host:7667",
                           "udpm://239.255.76.67:0",
                           "udpm://239.255.76.67:65536",
                           "udpm://239.255.76.67:76x",
                           "udpm://?ttl=256",
                           "udpm://?ttl=-1",
                           "udpm://?ttl=",
                           "udpm://?ttl",
                           "udpm://?recv_buf_size=0",
                           "udpm://?recv_buf_size=99999999999",
                           "udpm://?tll=1"}) {
    const auto status = CheckBusUrl(text);
    ASSERT_FALSE(status.ok()) << text;
    EXPECT_EQ(status.error().code, core::ErrorCode::kInvalid) << text;
    EXPECT_EQ(status.error().field, "lcm");
    const auto bus = OpenLcmBus(text);
    ASSERT_FALSE(bus.ok()) << text;
    EXPECT_EQ(bus.error().message, status.error().message);
    const auto tap = LcmTap::Open(text);
    ASSERT_FALSE(tap.ok()) << text;
    EXPECT_EQ(tap.error().message, status.error().message);
  }
}

TEST(BusUrl, OfABusWithoutANetworkIsTaken) {
  EXPECT_TRUE(CheckBusUrl("memq://").ok());
  EXPECT_TRUE(CheckBusUrl("file://run.lcm?mode=w").ok());
  const auto bus = OpenLcmBus("memq://");
  ASSERT_TRUE(bus.ok());
  std::string heard;
  bus.value()->Subscribe("A.*",
                         [&](const std::string& channel, MessageBus::Bytes) { heard = channel; });
  bus.value()->Publish("AB", {});
  bus.value()->Handle(std::chrono::seconds(10));
  EXPECT_EQ(heard, "AB");
}

}  // namespace
}  // namespace faultlab::hardware

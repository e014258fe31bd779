// This program's bus and liblcm's tools, over real UDP multicast (main: private_network.cc).
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <future>
#include <iterator>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "hardware/clock.h"
#include "hardware/lcm/lcm_event_file.h"
#include "hardware/lcm/lcm_tap.h"
#include "hardware/lcm/message_bus.h"
#include "tests/hardware/lcm_datagrams.h"
#include "tests/system/network/lcm_logger.h"
#include "tests/system/network/udp_relay.h"

namespace faultlab::hardware {
namespace {

TEST(UdpmBus, ABusWithoutARouteSaysWhatToDo) {
  const std::string url = "udpm://239.1.2.3:7667";
  const auto bus = OpenLcmBus(url);
  ASSERT_FALSE(bus.ok());
  EXPECT_EQ(bus.error().code, core::ErrorCode::kUnavailable);
  EXPECT_NE(bus.error().message.find("ip route add"), std::string::npos) << bus.error().message;
  EXPECT_NE(bus.error().message.find("No such device"), std::string::npos) << bus.error().message;
  EXPECT_FALSE(LcmTap::Open(url).ok());
}

std::vector<LcmEvent> EventsOf(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  LcmEventFile file(in);
  std::vector<LcmEvent> events;
  for (auto event = file.Next(); event.ok() && event.value(); event = file.Next()) {
    events.push_back(std::move(event).value().value());
  }
  return events;
}

TEST(UdpmBus, LongMessagesPassBetweenOurBusAndLiblcm) {
  const std::string path = testing::TempDir() + "/network_long.lcm";
  const auto bus = OpenLcmBus(Url(kAgentPort)).value();
  // Sizes around those at which liblcm begins another fragment.
  const std::size_t sizes[] = {
      0, 1, 1500, 65'492, 65'493, 65'494, 130'967, 130'968, 130'969, 200'000};
  {
    // Sent until lcm-logger has written each of them, because its socket buffer is small.
    Logger logger(path);
    std::set<std::size_t> missing(std::begin(sizes), std::end(sizes));
    const auto clock = MakeSteadyClock();
    while (!missing.empty()) {
      ASSERT_TRUE(logger.runs()) << "lcm-logger (liblcm-bin) does not run";
      for (const std::size_t size : missing) {
        bus->Publish("LONG.A", SomeBytes(size));
        (void)clock->SleepUntil(clock->Now() + std::chrono::milliseconds(20));
      }
      for (const LcmEvent& event : EventsOf(path)) missing.erase(event.data.size());
    }
  }
  const std::vector<LcmEvent> logged = EventsOf(path);
  for (const LcmEvent& event : logged) {
    ASSERT_EQ(event.channel, "LONG.A");
    ASSERT_EQ(event.data, SomeBytes(event.data.size()));
  }
  const auto ear = OpenLcmBus(Url(kAgentPort)).value();
  std::vector<std::vector<std::uint8_t>> heard;
  ear->Subscribe("LONG\\..*", [&](const std::string&, MessageBus::Bytes bytes) {
    heard.emplace_back(bytes.begin(), bytes.end());
  });
  UdpProbe probe(kAgentPort);
  const std::string play =
      "lcm-logplayer --speed=20 --lcm-url='" + Url(kAgentPort) + "' " + path + " > /dev/null";
  // Received while the log is played, because all of it at once may exceed a socket buffer.
  auto played = std::async(std::launch::async, [&play] { return std::system(play.c_str()); });
  const auto quiet_clock = MakeSteadyClock();
  auto last = quiet_clock->Now();
  while (heard.size() < logged.size() && quiet_clock->Now() - last < std::chrono::seconds(10)) {
    const std::size_t before = heard.size();
    ear->Handle(std::chrono::milliseconds(1000));
    if (heard.size() != before) last = quiet_clock->Now();
  }
  ASSERT_EQ(played.get(), 0);
  ASSERT_EQ(heard.size(), logged.size());
  std::vector<Datagram> cut_by_us;
  for (std::size_t i = 0; i < logged.size(); ++i) {
    EXPECT_EQ(heard[i], logged[i].data);
    for (Datagram& datagram :
         DatagramsOf(static_cast<std::uint32_t>(i), logged[i].channel, logged[i].data)) {
      cut_by_us.push_back(std::move(datagram));
    }
  }
  for (const Datagram& expected : cut_by_us) {
    const auto cut_by_liblcm = probe.Receive();
    ASSERT_TRUE(cut_by_liblcm.has_value());
    EXPECT_TRUE(*cut_by_liblcm == expected) << "of " << expected.size() << " bytes";
  }
  EXPECT_FALSE(probe.Receive().has_value());
}

}  // namespace
}  // namespace faultlab::hardware

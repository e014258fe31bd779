// A complete server on a bus on which anybody can send and listen.
#include <gtest/gtest.h>
#include <soci/soci.h>

#include <boost/json.hpp>
#include <map>
#include <mutex>
#include <set>
#include <thread>

#include "faultlab_msgs/estimates_t.hpp"
#include "faultlab_msgs/event_t.hpp"
#include "faultlab_msgs/rig_announce_t.hpp"
#include "faultlab_msgs/sample_t.hpp"
#include "hardware/lcm/channels.h"
#include "hardware/lcm/sealed_message.h"
#include "tests/server/api/api_world.h"
#include "tests/support/await.h"
#include "tests/system/network/network_world.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

/// Listens to the tap and counts the messages of each run.
class Listener {
 public:
  Listener() : bus_(hardware::OpenLcmBus(hardware::Url(hardware::kAgentPort)).value()) {
    bus_->Subscribe("FAULTLAB\\..*", [this](const std::string& channel, auto bytes) {
      using hardware::FromBytes;
      if (const auto sample = FromBytes<faultlab_msgs::sample_t>(bytes)) Count(sample->run);
      if (const auto said = FromBytes<faultlab_msgs::estimates_t>(bytes)) Count(said->run);
      if (const auto event = FromBytes<faultlab_msgs::event_t>(bytes)) Count(event->run);
      (void)channel;
    });
    thread_ = std::thread([this] {
      while (!stop_) bus_->Handle(std::chrono::milliseconds(5));
    });
  }
  ~Listener() {
    stop_ = true;
    thread_.join();
  }
  std::map<std::string, int> runs() const {
    const std::lock_guard lock(mutex_);
    return runs_;
  }

 private:
  void Count(const std::string& run) {
    const std::lock_guard lock(mutex_);
    ++runs_[run];
  }
  std::unique_ptr<hardware::MessageBus> bus_;
  mutable std::mutex mutex_;
  std::map<std::string, int> runs_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

class ServerOnBus : public ApiTest {
 protected:
  ServerOnBus() {
    config_.lcm_url = hardware::Url(hardware::kAgentPort);
    config_.lcm_keys = hardware::KeyFolder();
    Restart();
  }
  void Restart() {
    application_.reset();
    auto opened = Application::Open(config_);
    ASSERT_TRUE(opened.ok()) << opened.error().message;
    application_ = std::move(opened).value();
  }
  std::map<std::string, json::object> Rigs(const Person& who) {
    std::map<std::string, json::object> rigs;
    const json::object answer = Ok(Call(who, "GET rigs"));
    for (const json::value& rig : answer.at("items").as_array()) {
      const std::string id(rig.at("id").as_string());
      EXPECT_FALSE(rigs.contains(id)) << id << " is there twice";
      rigs[id] = rig.as_object();
    }
    return rigs;
  }
  std::string StartRun(const Person& who, const std::string& body) {
    return Id(Ok(Call(who, "POST runs", body), 201));
  }
  /// Waits until the run is stored; its messages on the bus have arrived by then.
  void Await(const Person& who, const std::string& run) {
    application_->runs().Wait(run);
    EXPECT_EQ(Ok(Call(who, "GET runs/" + run)).at("state"), "finished");
  }
  int LabRigs() {
    const auto count = [](Transaction& tx) -> core::Result<int> {
      int rows = 0;
      tx.sql() << "SELECT COUNT(*) FROM lab_rig", soci::into(rows);
      return rows;
    };
    return database_->Read(count).value();
  }
};

void Forge(hardware::MessageBus& bus, const std::string& name) {
  faultlab_msgs::rig_announce_t said{};
  said.rig = name;
  said.rig_class = "\xff\xfe";
  said.state = "idle";
  bus.Publish(hardware::kAnnounceChannel, hardware::ToBytes(said));
  hardware::RigKey own;
  own.fill(7);
  bus.Publish(hardware::kAnnounceChannel, hardware::Sealed(said, hardware::kAnnounceChannel, own));
}

TEST_F(ServerOnBus, ForgedAnnouncementsChangeNothingNowOrAfterARestart) {
  const Person op = Make("operator-1", Role::kOperator);
  const auto bus = hardware::OpenLcmBus(hardware::Url(hardware::kAgentPort)).value();
  const std::set<std::string> own = {"sim-1", "sim-2", "sim-3", "sim-4", "bench-1", "bench-2"};
  WaitForBenches(2);
  const int rows = LabRigs();
  hardware::AgentHere agent("true-1", 1.0, 0.0);
  for (const bool restarted : {false, true}) {
    for (int i = 0; i < 300; ++i) Forge(*bus, "invented-" + std::to_string(i));
    for (int i = 0; i < 20; ++i) {
      for (const std::string& name : own) Forge(*bus, name);
    }
    while (!Rigs({}).contains("true-1") || Rigs(op).size() < 8) std::this_thread::yield();
    const auto seen = Rigs({});
    EXPECT_EQ(seen.size(), own.size() + 1) << "a guest sees no invented name";
    for (const std::string& name : own) {
      EXPECT_TRUE(seen.at(name).at("link").is_null()) << name << " has become a far rig";
    }
    const auto shown = Rigs(op);
    EXPECT_GT(shown.size(), seen.size()) << "an operator sees who asks to be let in";
    EXPECT_LE(shown.size(), seen.size() + 64);
    for (const auto& [id, rig] : shown) {
      if (seen.contains(id)) continue;
      EXPECT_FALSE(rig.at("link").at("key_known").as_bool());
      EXPECT_EQ(Call(kNobody, "POST runs", R"({"rig":")" + id + R"("})").status, 404);
    }
    for (const char* sim : {"sim-1", "sim-2", "sim-3", "sim-4"}) {
      Await({}, StartRun({}, R"({"duration_s":1,"rig":")" + std::string(sim) + R"("})"));
    }
    while (LabRigs() < rows + 1) std::this_thread::yield();
    EXPECT_EQ(LabRigs(), rows + 1) << "true-1 alone has come";
    if (!restarted) Restart();
  }
}

TEST_F(ServerOnBus, ARigThatAForgeryMadeAFarOneIsASimulatorAgain) {
  application_.reset();
  const auto spoil = [](Transaction& tx) -> core::Status {
    tx.sql() << "UPDATE lab_rig SET rig_class = 'forged', elastic = 0, status = 0, "
                "server = '', cleaning_due_ms = 0 WHERE id = 'sim-1'";
    return core::Done{};
  };
  ASSERT_TRUE(database_->Write(Durability::kPromise, spoil).ok());
  Restart();
  Await({}, StartRun({}, R"({"duration_s":1,"rig":"sim-1"})"));
  bool found = false;
  const json::object classes = Ok(Call(kNobody, "GET rig-classes"));
  for (const json::value& each : classes.at("items").as_array()) {
    EXPECT_NE(each.at("id"), "forged");
    for (const json::value& rig : each.at("members").as_array()) {
      found = found || rig.at("id") == "sim-1";
    }
  }
  EXPECT_TRUE(found);
}

TEST_F(ServerOnBus, TheTapIsSilentForHiddenFaultsAlsoInAJobAndInAReplay) {
  const Person teacher = Make("teacher", Role::kInstructor);
  const auto made = [&](const char* visible) {
    const json::object set = Ok(Call(teacher,
                                     "POST fault-sets",
                                     std::string(R"({"name":"s","visible":)") + visible +
                                         R"(,"faults":[{"component":"R1","value":100,"at_s":1}]})"),
                                201);
    return Id(set);
  };
  const std::string hidden = made("false");
  const std::string shown = made("true");
  Listener listener;
  const auto run = [&](const std::string& body) {
    const std::string id = StartRun(teacher, body);
    Await(teacher, id);
    return id;
  };
  const std::string silent = run(R"({"duration_s":3,"fault_set":)" + hidden + "}");
  const std::string replay = run(R"({"recording":")" + silent + R"("})");
  const std::string again = run(R"({"recording":")" + replay + R"("})");
  const json::object batch = Ok(
      Call(teacher, "POST jobs", R"({"runs":[{"duration_s":3,"fault_set":)" + hidden + "}]}"), 202);
  const std::string job(batch.at("items").at(0).at("id").as_string());
  json::object done;
  ASSERT_TRUE(tests::Await([&] {
    done = Ok(Call(teacher, "GET jobs/" + job));
    return done.at("state") == "finished";
  }));
  // The tap sends other runs, in order: messages of the hidden ones would have arrived by now.
  const std::string told = run(R"({"duration_s":3,"fault_set":)" + shown + "}");
  while (listener.runs()[told] < 100) std::this_thread::yield();
  const auto runs = listener.runs();
  const std::string of_job(done.at("run").as_string());
  for (const std::string& id : {silent, replay, again, of_job}) EXPECT_FALSE(runs.contains(id));
}

}  // namespace
}  // namespace faultlab::server

#include "hardware/lcm/lcm_tap.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <lcm/lcm-cpp.hpp>
#include <sstream>

#include "hardware/lcm/lcm_log.h"
#include "hardware/replay_rig.h"
#include "hardware/simulated/simulated_rig.h"
#include "tests/hardware/rig_runs.h"
#include "tests/hardware/wire_message.h"
#include "tests/paper_bench.h"

namespace faultlab::hardware {
namespace {

class LcmLog : public testing::Test {
 protected:
  LcmLog()
      : path_(testing::TempDir() + "/" +
              testing::UnitTest::GetInstance()->current_test_info()->name() + ".lcm") {
    std::filesystem::remove(path_);
  }
  ~LcmLog() override { std::filesystem::remove(path_); }

  const std::string path_;
};

RunLog SomeRun() {
  SimulatedRigOptions options;
  options.speed = 0.0;
  const auto rig = MakeSimulatedRig(options);
  RunPlan plan = SquarePlan(200);
  plan.faults = {{.component = paper::kR1, .value = 56.0, .at_s = 1.0}};
  EXPECT_TRUE(rig->Arm(plan, Epoch{1}).ok());
  EXPECT_TRUE(rig->Start(Epoch{1}).ok());
  return Drain(*rig);
}

void ExpectSame(const std::vector<core::Sample>& a, const std::vector<core::Sample>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k) {
    EXPECT_EQ(a[k].index, b[k].index);
    EXPECT_EQ(a[k].t_s, b[k].t_s);
    EXPECT_EQ(a[k].uc_v, b[k].uc_v);
    EXPECT_EQ(a[k].um_v, b[k].um_v);
    EXPECT_EQ(a[k].ia_a, b[k].ia_a);
    EXPECT_EQ(a[k].n_rpm, b[k].n_rpm);
  }
}

TEST_F(LcmLog, OfATapGivesTheRunBackBitEqual) {
  const RunLog run = SomeRun();
  {
    auto tap = LcmTap::Open("file://" + path_ + "?mode=w");
    ASSERT_TRUE(tap.ok());
    LcmTap::Stream stream(*tap.value(), "sim-1", "run-7", Epoch{3});
    for (const RigEvent& event : run.events) stream.Publish(event, 0.0);
    for (const core::Sample& sample : run.samples) {
      core::Frame frame{.sample = sample, .estimates = {}};
      frame.estimates[2].theta = {2.1, -1.1, -0.57};
      stream.Publish(frame);
    }
    EXPECT_EQ(tap.value()->published(), run.events.size() + 2 * run.samples.size());
    EXPECT_EQ(tap.value()->failed(), 0u);
  }
  const core::Result<LcmRecord> record = ReadLcmLog(path_, "", paper::Bench());
  ASSERT_TRUE(record.ok());
  EXPECT_EQ(record.value().rig, "sim-1");
  EXPECT_EQ(record.value().run, "run-7");
  EXPECT_EQ(record.value().lost_samples, 0);
  ExpectSame(record.value().samples, run.samples);
  ASSERT_EQ(record.value().events.size(), run.events.size());
  for (std::size_t i = 0; i < run.events.size(); ++i) {
    EXPECT_EQ(record.value().events[i].kind, run.events[i].kind);
    EXPECT_EQ(record.value().events[i].index, run.events[i].index);
    EXPECT_EQ(record.value().events[i].value, run.events[i].value);
  }
}

TEST_F(LcmLog, OfARecordingReplaysThroughTheReplayRig) {
  const RunLog run = SomeRun();
  LcmRecord record{.rig = "bench-2",
                   .run = "r",
                   .samples = run.samples,
                   .events = run.events,
                   .lost_samples = 0};
  ASSERT_TRUE(WriteLcmLog(path_, record, 1'700'000'000'000'000).ok());
  core::Result<LcmRecord> read = ReadLcmLog(path_, "r", paper::Bench());
  ASSERT_TRUE(read.ok());
  ReplayRigOptions options;
  options.bench = &paper::Bench();
  options.speed = 0.0;
  const auto rig = MakeReplayRig(read.value().samples, options);
  ASSERT_TRUE(rig->Arm(ReplayPlan(0.01), Epoch{1}).ok());
  ASSERT_TRUE(rig->Start(Epoch{1}).ok());
  ExpectSame(Drain(*rig).samples, run.samples);
}

TEST_F(LcmLog, IsReadByTheReaderOfLcmItself) {
  const RunLog run = SomeRun();
  LcmRecord record{.rig = "bench-2",
                   .run = "r",
                   .samples = run.samples,
                   .events = run.events,
                   .lost_samples = 0};
  ASSERT_TRUE(WriteLcmLog(path_, record, 1'700'000'000'000'000).ok());
  lcm::LogFile log(path_, "r");
  ASSERT_TRUE(log.good());
  std::size_t samples = 0;
  std::size_t events = 0;
  std::int64_t number = 0;
  while (const lcm::LogEvent* event = log.readNextEvent()) {
    EXPECT_EQ(event->eventnum, number++);
    EXPECT_GE(event->timestamp, 1'700'000'000'000'000);
    if (event->channel == "FAULTLAB.bench-2.EVENT") ++events;
    faultlab_msgs::sample_t sample;
    if (event->channel != "FAULTLAB.bench-2.SAMPLE") continue;
    ASSERT_EQ(sample.decode(event->data, 0, event->datalen), event->datalen);
    EXPECT_EQ(sample.index, run.samples[samples++].index);
  }
  EXPECT_EQ(samples, run.samples.size());
  EXPECT_EQ(events, run.events.size());
}

TEST_F(LcmLog, CountsTheSamplesThatTheBusLost) {
  const RunLog run = SomeRun();
  const LcmRecord whole{
      .rig = "sim-1", .run = "x", .samples = run.samples, .events = {}, .lost_samples = 0};
  ASSERT_TRUE(WriteLcmLog(path_, whole, 0).ok());
  // Removes the part between two marks of the file: a log cut in its middle.
  std::ifstream in(path_, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(in)), {});
  const std::size_t event_bytes = bytes.size() / run.samples.size();
  ASSERT_EQ(event_bytes * run.samples.size(), bytes.size());
  std::ofstream(path_, std::ios::binary | std::ios::trunc)
      << bytes.substr(0, 50 * event_bytes) << bytes.substr(60 * event_bytes);
  const core::Result<LcmRecord> record = ReadLcmLog(path_, "x", paper::Bench());
  ASSERT_TRUE(record.ok());
  EXPECT_EQ(record.value().samples.size(), run.samples.size() - 10);
  EXPECT_EQ(record.value().lost_samples, 10);
}

TEST_F(LcmLog, ThatIsMissingOrOfSomethingElseSaysSo) {
  EXPECT_EQ(ReadLcmLog(path_ + ".no", "", paper::Bench()).error().code, core::ErrorCode::kNotFound);
  std::ofstream(path_) << "not an LCM log at all";
  EXPECT_EQ(ReadLcmLog(path_, "", paper::Bench()).error().code, core::ErrorCode::kNotFound);
}

/// A log of one event with these lengths in its header, and as many bytes as `data` has.
std::string LogWithLengths(std::int32_t channel_bytes,
                           std::int32_t data_bytes,
                           const std::string& channel,
                           const std::string& data) {
  std::vector<std::uint8_t> head(28);
  PutInt(head, 0, static_cast<std::int32_t>(0xeda1da01));
  PutInt(head, 20, channel_bytes);
  PutInt(head, 24, data_bytes);
  return std::string(head.begin(), head.end()) + channel + data;
}

TEST_F(LcmLog, WithLengthsThatNoEventHasSaysSo) {
  for (const std::int32_t length : kBadLengths) {
    if (length != 1 << 24) {
      std::istringstream data(LogWithLengths(8, length, "R.SAMPLE", "some bytes"));
      const auto record = ReadLcmLog(data, "run.lcm", "", paper::Bench());
      ASSERT_FALSE(record.ok()) << length;
      EXPECT_EQ(record.error().code, core::ErrorCode::kInvalid) << length;
      EXPECT_THAT(record.error().message, testing::HasSubstr("run.lcm: event 0")) << length;
    }
    std::istringstream channel(LogWithLengths(length, 4, "R.SAMPLE", "some bytes"));
    EXPECT_EQ(ReadLcmLog(channel, "run.lcm", "", paper::Bench()).error().code,
              core::ErrorCode::kInvalid)
        << length;
  }
}

TEST_F(LcmLog, WithAMessageWhoseLengthsAreBadSaysSoOrSkipsIt) {
  core::Random random(4);
  for (int i = 0; i < 20; ++i) {
    const WireMessage sample = MakeWireMessage<faultlab_msgs::sample_t>(random);
    const WireMessage event = MakeWireMessage<faultlab_msgs::event_t>(random);
    for (const std::int32_t length : kBadLengths) {
      const auto log_of = [&](const WireMessage& wire, std::size_t at, const std::string& channel) {
        std::vector<std::uint8_t> bytes = wire.bytes;
        PutInt(bytes, at, length);
        return LogWithLengths(static_cast<std::int32_t>(channel.size()),
                              static_cast<std::int32_t>(bytes.size()),
                              channel,
                              std::string(bytes.begin(), bytes.end()));
      };
      for (const std::size_t at : sample.strings) {
        std::istringstream log(log_of(sample, at, "FAULTLAB.r.SAMPLE"));
        EXPECT_THAT(ReadLcmLog(log, "run.lcm", "", paper::Bench()).error().message,
                    testing::HasSubstr("1 message of channel FAULTLAB.r.SAMPLE skipped: could "
                                       "not be decoded"));
      }
      for (const std::size_t at : event.strings) {
        std::istringstream log(log_of(event, at, "FAULTLAB.r.EVENT"));
        EXPECT_THAT(ReadLcmLog(log, "run.lcm", "", paper::Bench()).error().message,
                    testing::HasSubstr("holds no samples"));
      }
    }
  }
}

TEST_F(LcmLog, WithMoreThanTheRunSaysInWordsWhatWasSkipped) {
  const RunLog run = SomeRun();
  const auto write = [&](const std::string& name) {
    LcmRecord record{
        .rig = "sim-1", .run = name, .samples = run.samples, .events = {}, .lost_samples = 0};
    EXPECT_TRUE(WriteLcmLog(path_, record, 0).ok());
    std::ifstream in(path_, std::ios::binary);
    return std::string((std::istreambuf_iterator<char>(in)), {});
  };
  std::string bytes = write("one") + write("other");
  for (int i = 0; i < 12; ++i) {
    const std::string channel = "CAMERA." + std::to_string(10 + i);
    for (int k = 0; k < 3; ++k) {
      bytes += LogWithLengths(static_cast<std::int32_t>(channel.size()), 4, channel, "pict");
    }
  }
  bytes += LogWithLengths(8, 5, "R.SAMPLE", "five5");
  bytes += LogWithLengths(7, 5, "R.EVENT", "five5");
  std::istringstream log(bytes);
  const auto record = ReadLcmLog(log, "run.lcm", "", paper::Bench());
  ASSERT_TRUE(record.ok());
  ExpectSame(record.value().samples, run.samples);
  const std::vector<std::string> said = record.value().skipped.Sentences();
  ASSERT_EQ(said.size(), 14u);
  EXPECT_EQ(said[0],
            "3 messages of channel CAMERA.10 skipped: neither samples nor events of a run");
  EXPECT_EQ(said[10], "6 messages of 2 more channels skipped: neither samples nor events of a run");
  EXPECT_EQ(said[11], "1 message of channel R.EVENT skipped: could not be decoded");
  EXPECT_EQ(said[12], "1 message of channel R.SAMPLE skipped: could not be decoded");
  EXPECT_EQ(said[13], std::to_string(run.samples.size()) + " messages of other runs skipped");
  std::istringstream whole(write("one"));
  EXPECT_TRUE(ReadLcmLog(whole, "run.lcm", "", paper::Bench()).value().skipped.Sentences().empty());
}

TEST_F(LcmLog, ThatIsCutInsideAnEventGivesWhatIsWhole) {
  const RunLog run = SomeRun();
  const LcmRecord three{.rig = "sim-1",
                        .run = "x",
                        .samples = {run.samples.begin(), run.samples.begin() + 3},
                        .events = {},
                        .lost_samples = 0};
  ASSERT_TRUE(WriteLcmLog(path_, three, 0).ok());
  std::ifstream in(path_, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(in)), {});
  const std::size_t event_bytes = bytes.size() / 3;
  for (std::size_t size = 2 * event_bytes; size < bytes.size(); ++size) {
    std::istringstream cut(bytes.substr(0, size));
    const auto record = ReadLcmLog(cut, "run.lcm", "x", paper::Bench());
    ASSERT_TRUE(record.ok()) << size;
    EXPECT_EQ(record.value().samples.size(), 2u) << size;
  }
}

TEST(LcmTap, ThatDoesNotOpenSaysWhatToDo) {
  const auto tap = LcmTap::Open("nonsense://");
  ASSERT_FALSE(tap.ok());
  EXPECT_EQ(tap.error().code, core::ErrorCode::kInvalid);
  EXPECT_THAT(tap.error().message, testing::HasSubstr("multicast"));
}

}  // namespace
}  // namespace faultlab::hardware

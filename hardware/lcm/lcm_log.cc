#include "hardware/lcm/lcm_log.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <limits>

#include <lcm/lcm-cpp.hpp>

#include "hardware/lcm/lcm_event_file.h"
#include "hardware/lcm/message_codec.h"

namespace faultlab::hardware {
namespace {

bool EndsWith(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

template <typename Message>
void Append(lcm::LogFile& log,
            std::int64_t timestamp_us,
            const std::string& channel,
            const Message& message) {
  std::vector<std::uint8_t> bytes = ToBytes(message);
  lcm::LogEvent event;
  event.timestamp = timestamp_us;
  event.channel = channel;
  event.datalen = static_cast<std::int32_t>(bytes.size());
  event.data = bytes.data();
  log.writeEvent(&event);
}

}  // namespace

core::Result<LcmRecord> ReadLcmLog(const std::string& path,
                                   const std::string& run,
                                   const core::Bench& bench) {
  std::ifstream in(path, std::ios::binary);
  if (!in) {
    return core::Error{.code = core::ErrorCode::kNotFound,
                       .message = path + " cannot be read as an LCM log",
                       .field = {}};
  }
  return ReadLcmLog(in, path, run, bench);
}

core::Result<LcmRecord> ReadLcmLog(std::istream& in,
                                   const std::string& path,
                                   const std::string& run,
                                   const core::Bench& bench) {
  LcmEventFile log(in);
  LcmRecord record;
  record.run = run;
  std::int64_t seq_max = -1;
  while (true) {
    const core::Result<std::optional<LcmEvent>> next = log.Next();
    if (!next) {
      return core::Error{
          .code = next.error().code, .message = path + ": " + next.error().message, .field = {}};
    }
    if (!next.value()) break;
    const LcmEvent& event = *next.value();
    if (EndsWith(event.channel, ".SAMPLE")) {
      const auto sample = FromBytes<faultlab_msgs::sample_t>(event.data);
      if (!sample) {
        return core::Error{.code = core::ErrorCode::kInvalid,
                           .message = path + ": event " + std::to_string(event.number) +
                                      " is no faultlab_msgs.sample_t",
                           .field = {}};
      }
      if (record.run.empty()) record.run = sample->run;
      if (sample->run != record.run) continue;
      record.rig = sample->rig;
      record.samples.push_back(Decode(*sample));
      seq_max = std::max(seq_max, sample->seq);
    } else if (EndsWith(event.channel, ".EVENT")) {
      const auto said = FromBytes<faultlab_msgs::event_t>(event.data);
      if (!said || (!record.run.empty() && said->run != record.run)) continue;
      if (record.run.empty()) record.run = said->run;
      if (const std::optional<RigEvent> known = Decode(*said, bench))
        record.events.push_back(*known);
    }
  }
  const auto by_index = [](const core::Sample& a, const core::Sample& b) {
    return a.index < b.index;
  };
  std::stable_sort(record.samples.begin(), record.samples.end(), by_index);
  record.samples.erase(
      std::unique(record.samples.begin(),
                  record.samples.end(),
                  [](const core::Sample& a, const core::Sample& b) { return a.index == b.index; }),
      record.samples.end());
  if (record.samples.empty()) {
    return core::Error{
        .code = core::ErrorCode::kNotFound,
        .message = path + " holds no samples" + (run.empty() ? std::string() : " of run " + run),
        .field = {}};
  }
  record.lost_samples = seq_max + 1 - static_cast<std::int64_t>(record.samples.size());
  return record;
}

core::Status WriteLcmLog(const std::string& path,
                         const LcmRecord& record,
                         std::int64_t begun_unix_us) {
  // Whole or not at all.
  const std::string partial = path + ".partial";
  {
    lcm::LogFile log(partial, "w");
    if (!log.good()) {
      return core::Error{.code = core::ErrorCode::kUnavailable,
                         .message = partial + " cannot be written",
                         .field = {}};
    }
    const auto time_us = [begun_unix_us](double t_s) {
      return begun_unix_us + static_cast<std::int64_t>(t_s * 1e6);
    };
    std::size_t next_event = 0;
    std::int64_t seq = 0;
    double t_s = 0.0;
    const auto write_events_to = [&](std::int64_t index) {
      while (next_event < record.events.size() && record.events[next_event].index <= index) {
        faultlab_msgs::event_t out;
        out.rig = record.rig;
        out.run = record.run;
        out.seq = static_cast<std::int64_t>(next_event);
        out.t_s = t_s;
        Encode(record.events[next_event++], out);
        Append(log, time_us(t_s), "FAULTLAB." + record.rig + ".EVENT", out);
      }
    };
    for (const core::Sample& sample : record.samples) {
      t_s = sample.t_s;
      write_events_to(sample.index);
      faultlab_msgs::sample_t out;
      out.rig = record.rig;
      out.run = record.run;
      out.epoch = 0;
      out.seq = seq++;
      out.sent_ns = time_us(t_s) * 1000;
      Encode(sample, out);
      Append(log, time_us(t_s), "FAULTLAB." + record.rig + ".SAMPLE", out);
    }
    write_events_to(std::numeric_limits<std::int64_t>::max());
  }
  std::error_code failed;
  std::filesystem::rename(partial, path, failed);
  if (failed) {
    return core::Error{.code = core::ErrorCode::kUnavailable,
                       .message = path + ": " + failed.message(),
                       .field = {}};
  }
  return core::Done{};
}

}  // namespace faultlab::hardware

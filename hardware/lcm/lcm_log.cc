#include "hardware/lcm/lcm_log.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <limits>

#include "hardware/lcm/lcm_event_file.h"
#include "hardware/lcm/message_codec.h"
#include "hardware/lcm/rig_name.h"

namespace faultlab::hardware {
namespace {

bool EndsWith(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

constexpr std::size_t kChannelsNamed = 10;
constexpr std::size_t kPieceBytes = 64 << 10;

std::string Messages(std::int64_t count) {
  return std::to_string(count) + (count == 1 ? " message" : " messages");
}

/// Of each channel, those beyond the first ten together.
void AddChannels(const std::map<std::string, std::int64_t>& channels,
                 const std::string& why,
                 std::vector<std::string>& sentences) {
  std::size_t named = 0;
  std::int64_t rest = 0;
  for (const auto& [channel, count] : channels) {
    if (++named > kChannelsNamed) {
      rest += count;
      continue;
    }
    sentences.push_back(Messages(count) + " of channel " + ShownText(channel, 100) +
                        " skipped: " + why);
  }
  if (rest == 0) return;
  sentences.push_back(Messages(rest) + " of " + std::to_string(named - kChannelsNamed) +
                      " more channels skipped: " + why);
}

}  // namespace

std::vector<std::string> LcmSkipped::Sentences() const {
  std::vector<std::string> sentences;
  AddChannels(channels, "neither samples nor events of a run", sentences);
  AddChannels(undecoded, "could not be decoded", sentences);
  if (other_runs > 0) sentences.push_back(Messages(other_runs) + " of other runs skipped");
  if (unknown_events > 0) {
    sentences.push_back(Messages(unknown_events) +
                        " of events that this version or this bench does not know skipped");
  }
  return sentences;
}

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
        ++record.skipped.undecoded[event.channel];
        continue;
      }
      if (record.run.empty()) record.run = sample->run;
      if (sample->run != record.run) {
        ++record.skipped.other_runs;
        continue;
      }
      record.rig = sample->rig;
      record.samples.push_back(Decode(*sample));
      seq_max = std::max(seq_max, sample->seq);
    } else if (EndsWith(event.channel, ".EVENT")) {
      const auto said = FromBytes<faultlab_msgs::event_t>(event.data);
      if (!said) {
        ++record.skipped.undecoded[event.channel];
        continue;
      }
      if (record.run.empty()) record.run = said->run;
      if (said->run != record.run) {
        ++record.skipped.other_runs;
      } else if (const std::optional<RigEvent> known = Decode(*said, bench)) {
        record.events.push_back(*known);
      } else {
        ++record.skipped.unknown_events;
      }
    } else {
      ++record.skipped.channels[event.channel];
    }
  }
  const auto by_index = [](const core::Sample& a, const core::Sample& b) {
    return a.index < b.index;
  };
  std::ranges::stable_sort(record.samples, by_index);
  record.samples.erase(
      std::unique(record.samples.begin(),
                  record.samples.end(),
                  [](const core::Sample& a, const core::Sample& b) { return a.index == b.index; }),
      record.samples.end());
  if (record.samples.empty()) {
    std::string message =
        path + " holds no samples" + (run.empty() ? std::string() : " of run " + run);
    for (const std::string& sentence : record.skipped.Sentences()) message += "; " + sentence;
    return core::Error{
        .code = core::ErrorCode::kNotFound, .message = std::move(message), .field = {}};
  }
  record.lost_samples = seq_max + 1 - static_cast<std::int64_t>(record.samples.size());
  return record;
}

void FormatLcmLog(const LcmRecord& record,
                  std::int64_t begun_unix_us,
                  const std::function<void(std::string_view)>& take) {
  const auto time_us = [begun_unix_us](double t_s) {
    return begun_unix_us + static_cast<std::int64_t>(t_s * 1e6);
  };
  std::int64_t number = 0;
  std::string bytes;
  const auto append = [&](double t_s, const char* kind, const auto& message) {
    AppendLcmEvent({.number = number++,
                    .timestamp_us = time_us(t_s),
                    .channel = "FAULTLAB." + record.rig + kind,
                    .data = ToBytes(message)},
                   bytes);
  };
  std::size_t next_event = 0;
  double t_s = 0.0;
  const auto append_events_to = [&](std::int64_t index) {
    while (next_event < record.events.size() && record.events[next_event].index <= index) {
      faultlab_msgs::event_t out;
      out.rig = record.rig;
      out.run = record.run;
      out.seq = static_cast<std::int64_t>(next_event);
      out.t_s = t_s;
      Encode(record.events[next_event++], out);
      append(t_s, ".EVENT", out);
    }
  };
  std::int64_t seq = 0;
  for (const core::Sample& sample : record.samples) {
    t_s = sample.t_s;
    append_events_to(sample.index);
    faultlab_msgs::sample_t out;
    out.rig = record.rig;
    out.run = record.run;
    out.epoch = 0;
    out.seq = seq++;
    out.sent_ns = time_us(t_s) * 1000;
    Encode(sample, out);
    append(t_s, ".SAMPLE", out);
    if (bytes.size() >= kPieceBytes) {
      take(bytes);
      bytes.clear();
    }
  }
  append_events_to(std::numeric_limits<std::int64_t>::max());
  take(bytes);
}

core::Status WriteLcmLog(const std::string& path,
                         const LcmRecord& record,
                         std::int64_t begun_unix_us) {
  const std::string partial = path + ".partial";
  std::ofstream out(partial, std::ios::binary);
  FormatLcmLog(record, begun_unix_us, [&out](std::string_view piece) { out << piece; });
  out.close();
  if (!out) {
    return core::Error{.code = core::ErrorCode::kUnavailable,
                       .message = partial + " cannot be written",
                       .field = {}};
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

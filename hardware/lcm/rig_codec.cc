#include "hardware/lcm/rig_codec.h"

#include <string_view>

#include "core/types/utf8.h"
#include "hardware/lcm/channels.h"
#include "hardware/lcm/message_codec.h"
#include "hardware/lcm/rig_name.h"
#include "hardware/lcm/sealed_message.h"

namespace faultlab::hardware {
namespace {

constexpr std::size_t kAnnouncedTextMax = 200;

void EncodeHistogram(const TimeHistogram& histogram, faultlab_msgs::histogram_t& out) {
  static_assert(TimeHistogram::kBuckets == std::extent_v<decltype(out.counts)>);
  for (std::size_t i = 0; i < TimeHistogram::kBuckets; ++i) {
    out.counts[i] = static_cast<std::int64_t>(histogram.counts[i]);
  }
  out.sum_s = histogram.sum_s;
  out.worst_s = histogram.worst_s;
}

TimeHistogram DecodeHistogram(const faultlab_msgs::histogram_t& in) {
  TimeHistogram histogram;
  for (std::size_t i = 0; i < TimeHistogram::kBuckets; ++i) {
    histogram.counts[i] = static_cast<std::uint64_t>(in.counts[i]);
  }
  histogram.sum_s = in.sum_s;
  histogram.worst_s = in.worst_s;
  return histogram;
}

}  // namespace

void Encode(const RigDescription& description, faultlab_msgs::rig_announce_t& out) {
  out.rig_class = description.rig_class;
  out.bench = description.bench->id;
  out.behind = Name(description.kind);
  out.profile = description.profile;
  out.has_ua = description.has_ua;
  out.has_ia = description.has_ia;
  out.has_n = description.has_n;
  out.any_value = description.any_value;
  out.motor_faults = description.motor_faults;
  out.controls_speed = description.controls_speed;
  out.current_mode = description.bench->structure->drives_current();
  out.four_quadrants = description.amplifier_quadrants == core::Quadrants::kFour;
  out.uc_min_v = description.uc_v_min;
  out.uc_max_v = description.uc_v_max;
  out.delta_s = description.delta_s;
}

std::optional<faultlab_msgs::rig_announce_t> ReadAnnouncement(std::span<const std::uint8_t> bytes,
                                                              const std::string& rig,
                                                              const RigKey& key) {
  auto said = Opened<faultlab_msgs::rig_announce_t>(bytes, kAnnounceChannel, rig, key);
  if (!said) return std::nullopt;
  for (const std::string* text : {&said->rig_class,
                                  &said->bench,
                                  &said->behind,
                                  &said->profile,
                                  &said->calibration,
                                  &said->state,
                                  &said->trip,
                                  &said->holder}) {
    if (!core::IsUtf8(*text) || text->size() > kAnnouncedTextMax) return std::nullopt;
  }
  // A driver's own words: not worth losing the rig for.
  said->trip_text = ShownText(said->trip_text);
  return said;
}

bool IsForeignProtocol(std::span<const std::uint8_t> bytes,
                       const std::string& rig,
                       const RigKey& key) {
  if (CarriesMac(bytes, key)) return true;  // before 3
  const auto opened = OpenSealed(bytes, kAnnounceChannel, rig, key);
  return opened && opened->protocol != kProtocol;
}

void Decode(const faultlab_msgs::rig_announce_t& in, RigDescription& out) {
  out.rig_class = in.rig_class;
  out.profile = in.profile;
  out.has_ua = in.has_ua != 0;
  out.has_ia = in.has_ia != 0;
  out.has_n = in.has_n != 0;
  out.any_value = in.any_value != 0;
  out.motor_faults = in.motor_faults != 0;
  out.controls_speed = in.controls_speed != 0;
  out.amplifier_quadrants = in.four_quadrants != 0 ? core::Quadrants::kFour : core::Quadrants::kTwo;
  out.uc_v_min = in.uc_min_v;
  out.uc_v_max = in.uc_max_v;
  out.delta_s = in.delta_s;
}

void Encode(const std::optional<Trip>& trip, faultlab_msgs::rig_announce_t& out) {
  const Trip none;
  const Trip& from = trip ? *trip : none;
  out.trip = from.name;
  out.trip_value = from.value;
  out.trip_limit = from.limit;
  out.trip_index = from.index;
  out.trip_t_s = from.t_s;
  out.trip_text = from.text;
}

std::optional<Trip> DecodeTrip(const faultlab_msgs::rig_announce_t& in) {
  if (in.trip.empty()) return std::nullopt;
  return Trip{.name = in.trip,
              .value = in.trip_value,
              .limit = in.trip_limit,
              .index = in.trip_index,
              .t_s = in.trip_t_s,
              .text = in.trip_text};
}

void Encode(const LoopQuality& loop, faultlab_msgs::rig_announce_t& out) {
  EncodeHistogram(loop.lateness, out.lateness);
  EncodeHistogram(loop.actuation, out.actuation);
  out.loop_overruns = static_cast<std::int64_t>(loop.overruns);
  out.loop_missed_ticks = static_cast<std::int64_t>(loop.missed_ticks);
  out.loop_fifo = loop.fifo;
}

LoopQuality DecodeLoop(const faultlab_msgs::rig_announce_t& in) {
  return {.lateness = DecodeHistogram(in.lateness),
          .actuation = DecodeHistogram(in.actuation),
          .overruns = static_cast<std::uint64_t>(in.loop_overruns),
          .missed_ticks = static_cast<std::uint64_t>(in.loop_missed_ticks),
          .fifo = in.loop_fifo != 0};
}

std::optional<RigState> ParseRigState(std::string_view name) {
  using enum RigState;
  for (const RigState state : {kOffline, kIdle, kArmed, kRunning, kStopping, kTripped}) {
    if (Name(state) == name) return state;
  }
  return std::nullopt;
}

faultlab_msgs::rig_item_t ToItem(const RigMessage& message) {
  faultlab_msgs::rig_item_t item{};
  if (const auto* sample = std::get_if<core::Sample>(&message)) {
    CopyReadings(*sample, item);
    item.delta_s = sample->delta_s;
    return item;
  }
  const auto& event = std::get<RigEvent>(message);
  item.index = event.index;
  item.kind = Name(event.kind);
  item.component = event.component.exists() ? core::Name(event.component) : "";
  item.value = event.value;
  item.text = event.text;
  return item;
}

RigMessage FromItem(const faultlab_msgs::rig_item_t& item, const core::Bench& bench) {
  if (item.kind.empty()) {
    core::Sample sample;
    CopyReadings(item, sample);
    sample.delta_s = item.delta_s;
    return sample;
  }
  faultlab_msgs::event_t event;
  event.index = item.index;
  event.kind = item.kind;
  event.component = item.component;
  event.value = item.value;
  event.text = ShownText(item.text);
  if (std::optional<RigEvent> known = Decode(event, bench)) return *known;
  return RigEvent{.kind = RigEventKind::kRefused,
                  .index = item.index,
                  .text = "a message that this version does not know: " + ShownText(item.kind, 40)};
}

faultlab_msgs::rig_position_t ToPosition(const SelfTestPosition& position) {
  faultlab_msgs::rig_position_t out;
  out.component = position.component.exists() ? core::Name(position.component) : "";
  out.value = position.value;
  out.line = position.line;
  out.ok = position.ok ? 1 : 0;
  out.text = position.text;
  return out;
}

SelfTestPosition FromPosition(const faultlab_msgs::rig_position_t& in, const core::Bench& bench) {
  return {.component = bench.Find(in.component).value_or(core::Component()),
          .value = in.value,
          .line = ShownText(in.line, 40),
          .ok = in.ok != 0,
          .text = ShownText(in.text)};
}

faultlab_msgs::fault_t ToMessage(const core::Fault& fault) {
  faultlab_msgs::fault_t out;
  out.component = core::Name(fault.component);
  out.value = fault.value;
  out.at_s = fault.at_s;
  out.kind = static_cast<std::int8_t>(fault.kind);
  out.until_s = fault.until_s;
  return out;
}

std::optional<core::Fault> FromMessage(const faultlab_msgs::fault_t& in, const core::Bench& bench) {
  const std::optional<core::Component> component = bench.Find(in.component);
  if (!component || in.kind < 0 || in.kind > 2) return std::nullopt;
  return core::Fault{.component = *component,
                     .value = in.value,
                     .at_s = in.at_s,
                     .kind = static_cast<core::FaultKind>(in.kind),
                     .until_s = in.until_s};
}

}  // namespace faultlab::hardware

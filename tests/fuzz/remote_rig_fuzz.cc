// Messages from an agent to a server under the right key: the harness seals them. Records of kind 1
// byte, piece body.
#include "core/types/utf8.h"
#include "faultlab_msgs/rig_announce_t.hpp"
#include "faultlab_msgs/rig_reply_t.hpp"
#include "faultlab_msgs/rig_stream_t.hpp"
#include "hardware/lcm/channels.h"
#include "hardware/lcm/remote_rig.h"
#include "hardware/lcm/rig_name.h"
#include "tests/fuzz/sealed_input.h"

using namespace faultlab::hardware;  // NOLINT(google-build-using-namespace)
using faultlab::fuzz::Require;

namespace {

void Check(const RemoteRig& rig) {
  const RemoteRigInfo info = rig.info();
  for (const std::string* text : {&info.description.rig_class,
                                  &info.description.profile,
                                  &info.holder,
                                  &info.calibration,
                                  &info.refusal_text}) {
    Require(faultlab::core::IsUtf8(*text) && text->size() < 500);
  }
  if (info.trip)
    Require(faultlab::core::IsUtf8(info.trip->name) && faultlab::core::IsUtf8(info.trip->text));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace faultlab::fuzz;  // NOLINT(google-build-using-namespace)
  Input input(data, size);
  Nanoseconds now{1};
  RemoteRig rig(
      kRig,
      std::make_shared<DeafBus>(),
      {.holder = "lab/a", .key = Key(), .give_up = Nanoseconds(0), .queue_messages = 256},
      [&now] { return now; },
      [] { return std::int64_t{1}; });
  for (int i = 0; i < 16 && !input.empty(); ++i) {
    const int kind = input.Byte();
    const std::string_view body = input.Piece();
    now += Nanoseconds(static_cast<std::int64_t>(kind) * 1'000'000);
    const bool in_order = (kind & 4) != 0;  // so that it passes the first checks
    if (kind % 4 == 0) {
      SealedInput<faultlab_msgs::rig_announce_t> said(body);
      if (said.message && in_order) said.message->boot = 1;
      rig.OnAnnounce(said.Bytes(kAnnounceChannel));
    } else if (kind % 4 == 1) {
      SealedInput<faultlab_msgs::rig_reply_t> said(body);
      if (said.message && in_order) {
        said.message->boot = 1;
        said.message->holder = "lab/a";
      }
      rig.OnReply(said.Bytes(ReplyChannel(kRig)));
    } else if (kind % 4 == 2) {
      SealedInput<faultlab_msgs::rig_stream_t> said(body);
      if (said.message && in_order) said.message->boot = 1;
      rig.OnStream(said.Bytes(StreamChannel(kRig)));
    } else {
      rig.Poll();
    }
    Check(rig);
  }
  return 0;
}

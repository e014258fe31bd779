#include "hardware/lcm/rig_finder.h"

namespace faultlab::hardware {

std::string_view Name(RigRefusal refusal) {
  switch (refusal) {
    case RigRefusal::kHeldElsewhere:
      return "held_elsewhere";
    case RigRefusal::kNoKey:
      return "no_key";
    case RigRefusal::kOtherKey:
      return "other_key";
    case RigRefusal::kOtherProtocol:
      return "other_protocol";
    case RigRefusal::kBenchUnreadable:
      return "bench_unreadable";
    case RigRefusal::kBenchAwaited:
      return "bench_awaited";
  }
  return "?";
}

std::string RefusalText(RigRefusal refusal, const std::string& detail) {
  switch (refusal) {
    case RigRefusal::kHeldElsewhere:
      return "the rig is held by " + detail + ": wait until that lab releases it";
    case RigRefusal::kNoKey:
      return "its key is not here: copy its .key file from the agent's key folder into this "
             "server's";
    case RigRefusal::kOtherKey:
      return "its announcements are not made with the key that is here, or it is not the rig of "
             "this name: copy the agent's .key file here again";
    case RigRefusal::kOtherProtocol:
      return "its agent and this server are of versions that do not understand each other: update "
             "the older one";
    case RigRefusal::kBenchUnreadable:
      return "the description of its bench is refused: " + detail;
    case RigRefusal::kBenchAwaited:
      return "the description of its bench has not come yet: wait a few seconds";
  }
  return "?";
}

}  // namespace faultlab::hardware

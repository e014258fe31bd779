#include <array>

#include "hardware/lcm/rig_finder.h"

namespace faultlab::hardware {

std::string_view Name(RigRefusal refusal) {
  constexpr std::array<std::string_view, 6> kNames = {"held_elsewhere",
                                                      "no_key",
                                                      "other_key",
                                                      "other_protocol",
                                                      "bench_unreadable",
                                                      "bench_awaited"};
  return kNames[static_cast<std::size_t>(refusal)];
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

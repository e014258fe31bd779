#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/course/trials.h"
#include "server/storage/recording_store.h"
#include "server/wall_time.h"

namespace faultlab::server::course {

/// Somebody brought a record of a trial for a diagnosis while it was sealed.
struct Copy {
  std::optional<std::int64_t> account;  ///< nullopt: a guest
  std::string recording;                ///< what they brought
  WallTime at{};
};

std::vector<Copy> CopiesOf(const Trial& trial);
/// One of Trial::copies: of a recording that is about to be kept.
std::string CopyText(const RunRecord& recording);

}  // namespace faultlab::server::course

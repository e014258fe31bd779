#pragma once

#include "core/types/result.h"

namespace faultlab::server {

/// One answer for what does not exist and for what the asker may not see: it tells neither.
inline core::Error NotYours() {
  return core::Refuse("not_yours");
}

}  // namespace faultlab::server

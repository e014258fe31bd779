#include "core/types/component.h"

#include "core/types/check.h"

namespace faultlab::core {

const ComponentInfo& Component::info() const {
  LAB_CHECK(info_ != nullptr);
  return *info_;
}

}  // namespace faultlab::core

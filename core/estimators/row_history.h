#pragma once

#include "core/estimators/sliding_moments.h"

namespace faultlab::core {

/// Gives the kind of the newest sample's row when rows need samples up to `reach` back: valid only
/// if these reach + 1 samples are all good and consecutive, invalid if one of them is non-finite.
class RowHistory {
 public:
  explicit RowHistory(int reach_samples)
      : reach_(reach_samples), since_invalid_(reach_samples + 1) {}

  RowKind PushGood() {
    since_invalid_ += since_invalid_ <= reach_;
    since_break_ += since_break_ <= reach_;
    return Kind();
  }
  /// A sample that exists but must not be used (clipped).
  RowKind PushUnusable() {
    since_invalid_ += since_invalid_ <= reach_;
    since_break_ = 0;
    return Kind();
  }
  RowKind PushInvalid() {
    since_invalid_ = since_break_ = 0;
    return RowKind::kInvalid;
  }
  /// Samples are missing between the last one and the next.
  void Break() { since_break_ = 0; }

 private:
  RowKind Kind() const {
    if (since_invalid_ <= reach_) {
      return RowKind::kInvalid;
    }
    return since_break_ > reach_ ? RowKind::kValid : RowKind::kEmpty;
  }

  int reach_;
  int since_invalid_;    ///< good samples since an invalid one, at most reach + 1
  int since_break_ = 0;  ///< consecutive good samples, at most reach + 1
};

}  // namespace faultlab::core

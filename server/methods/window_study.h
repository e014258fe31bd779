#pragma once

#include <boost/json/object.hpp>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/bench/bench.h"
#include "core/paper/window_study.h"
#include "core/types/result.h"
#include "core/types/sample.h"

namespace faultlab::server {

/// What is asked of a study of windows and orders, in the words of a person.
struct StudyRequest {
  std::string windows = "50,100,200";            ///< K of SWA; empty: no SWA
  std::string integrals = "20:5,100:20,500:20";  ///< K:m of SIA; empty: no SIA
  std::string orders = "1";                      ///< of the model, each with each window
  std::string change = "auto";                   ///< "auto", "none" or the time in seconds
  double from_s = 0.5;                           ///< the start-up of the motor lies before it
  bool exact = false;   ///< SIA of order 1 with the paper's integration rule inverted
  bool affine = false;  ///< a constant column
};

/// As many estimators run side by side at most.
inline constexpr std::size_t kStudiedMax = 48;

/// What is studied.
struct StudiedRecord {
  std::span<const core::Sample> samples;
  const core::Bench& bench;
  double period_s = 0.0;
  double delta_s = 0.0;           ///< as learnt
  std::vector<double> changes_s;  ///< in order; "auto" is the first behind the start
  /// Samples times estimators: of a longer record the part around the change.
  std::size_t work_max = std::numeric_limits<std::size_t>::max();
  core::Curves curves = core::Curves::kDropped;
};

struct WindowStudy {
  std::vector<core::WindowStudyRow> rows;
  double period_s = 0.0;
  double from_s = 0.0;  ///< as asked, or the change before this one
  std::optional<double> change_s;
  std::optional<double> until_s;      ///< where the next change ends it
  std::size_t samples = 0;            ///< that were studied
  std::vector<std::string> left_out;  ///< windows that have too few samples on a side of the change

  /// Of the rows that differ from `row` in their order alone, itself among them, the order whose
  /// model leaves least for its size (BIC), before or after the change; 0 where none can be judged.
  int OrderFor(const core::WindowStudyRow& row, bool after) const;
};

/// Errors name k, km, order, exact or change.
core::Result<WindowStudy> StudyRecord(const StudyRequest& request, const StudiedRecord& record);

/// {"samples","period_s","from_s","change_s","until_s","left_out":[],"variants":[{"name","method","order","window",
/// "integral","transient_s","settling_s","unexcited_share","parameters":[{"name",
/// "before":{"mean","sd","sigma"},"after"}],"left":{"before":{"count","rms","ljung_box",
/// "white_below","white","bic","order"},"after"}}]}; "order" is OrderFor.
boost::json::object ToJson(const WindowStudy& study);

}  // namespace faultlab::server

#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/estimators/estimator_variant.h"
#include "core/paper/model_order.h"
#include "core/types/result.h"
#include "core/types/sample.h"

namespace faultlab::core {

/// Mean and spread of one parameter over the settled part of a stretch.
struct Spread {
  double mean = 0.0;
  double standard_deviation = 0.0;
  double reported_sigma = 0.0;  ///< root mean square of the reported standard errors
};

/// The estimates of one record with one window or data length (paper Figures 17-20): a short one
/// settles sooner, a long one has a smaller spread.
struct WindowStudyRow {
  VariantSpec spec;
  std::string name;                     ///< "swa_100", "sia_500_20", ..
  std::vector<std::string> parameters;  ///< names, in the order of the spreads
  std::vector<Spread> before;           ///< [start + transient, change)
  std::vector<Spread> after;            ///< [change + transient, end)
  /// Of the model whose parameters are the means; over the same samples for all orders of a window.
  OrderEvidence left_before;
  OrderEvidence left_after;
  int transient_samples = 0;  ///< TransientSamples
  /// Samples from the change until every parameter stays inside the range of its settled estimates:
  /// at most transient_samples; 0 when nothing changed; -1 without a change.
  int settling_samples = -1;
  double unexcited_share = 0.0;            ///< of settled samples whose status is not `excited`
  std::vector<VariantEstimate> estimates;  ///< one for each sample, to draw the curves, or empty
};

/// The paper's six: SWA K = 50, 100, 200 and SIA (20, 5), (100, 20), (500, 20), in its own rule.
std::vector<VariantSpec> PaperVariants();

enum class Curves { kKept, kDropped };

/// Rows with samples of both sides of a change, less one: K + n m - 1, of SWA K + n - 1.
int TransientSamples(const VariantSpec& spec);
/// The same window in another order, or itself.
bool DifferInOrderAlone(const VariantSpec& a, const VariantSpec& b);

/// Runs all variants over one record in one call.
/// @param start   first sample to use (the start-up of the motor lies before it)
/// @param change  sample at which the fault acts; samples.size() when there is none
/// Refuses (field) variants that do not exist and stretches without a settled sample.
Result<std::vector<WindowStudyRow>> StudyWindows(std::span<const Sample> samples,
                                                 std::size_t start,
                                                 std::size_t change,
                                                 std::span<const VariantSpec> variants,
                                                 Curves curves = Curves::kKept);

}  // namespace faultlab::core

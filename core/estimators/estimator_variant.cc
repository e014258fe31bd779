#include "core/estimators/estimator_variant.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/estimators/instrumental_swa.h"
#include "core/estimators/sia.h"
#include "core/estimators/swa.h"
#include "core/types/sample_intake.h"

namespace faultlab::core {
namespace {

template <typename Core>
class Wrapped final : public VariantEstimator {
 public:
  Wrapped(const VariantSpec& spec, const typename Core::Options& options)
      : VariantEstimator(spec, Core::kParameters),
        intake_(spec.period_s, kConverterRail_v, spec.channel),
        core_(options) {
    estimate_.theta.fill(std::numeric_limits<double>::quiet_NaN());
    estimate_.sigma.fill(std::numeric_limits<double>::quiet_NaN());
  }

  const VariantEstimate& Push(const Sample& sample) override {
    Feed(intake_.Classify(sample), sample, core_, VariantEstimator::spec().channel);
    const Estimate<Core::kParameters>& from = core_.estimate();
    std::copy(from.theta.begin(), from.theta.end(), estimate_.theta.begin());
    std::copy(from.sigma.begin(), from.sigma.end(), estimate_.sigma.begin());
    estimate_.sse = from.sse;
    estimate_.condition = from.condition;
    estimate_.status = from.status;
    estimate_.age_samples = from.age_samples;
    return estimate_;
  }

 private:
  SampleIntake intake_;
  Core core_;
  VariantEstimate estimate_;
};

template <int Order, RowForm Form>
std::unique_ptr<VariantEstimator> MakeSwa(const VariantSpec& spec) {
  static_assert(kSwaParameters<Order, Form> <= kVariantParametersMax);
  SwaOptions<Order, Form> options;
  options.window_samples = spec.window_samples;
  options.noise_sigma_v = spec.noise_sigma_v;
  return std::make_unique<Wrapped<Swa<Order, Form>>>(spec, options);
}

template <int Order, RowForm Form>
std::unique_ptr<VariantEstimator> MakeSia(const VariantSpec& spec) {
  static_assert(kSiaParameters<Order, Form> <= kVariantParametersMax);
  SiaOptions<Order, Form> options;
  options.window_samples = spec.window_samples;
  options.integral_samples = spec.integral_samples;
  options.period_s = spec.period_s;
  options.mode = spec.sia_mode;
  options.delta_s = spec.delta_s;
  options.noise_sigma_v = spec.noise_sigma_v;
  return std::make_unique<Wrapped<Sia<Order, Form>>>(spec, options);
}

/// Of order `Order` or more.
template <int Order>
std::unique_ptr<VariantEstimator> MakeOfOrder(const VariantSpec& spec) {
  if constexpr (Order > kOrderMax) {
    return nullptr;
  } else {
    if (spec.order != Order) return MakeOfOrder<Order + 1>(spec);
    constexpr RowForm kPlain = RowForm::kPlain;
    constexpr RowForm kAffine = RowForm::kAffine;
    if (spec.method == EstimatorMethod::kSwa) {
      return spec.affine ? MakeSwa<Order, kAffine>(spec) : MakeSwa<Order, kPlain>(spec);
    }
    return spec.affine ? MakeSia<Order, kAffine>(spec) : MakeSia<Order, kPlain>(spec);
  }
}

std::unique_ptr<VariantEstimator> MakeInstrumental(const VariantSpec& spec) {
  InstrumentalSwa::Options options;
  options.window_samples = spec.window_samples;
  return std::make_unique<Wrapped<InstrumentalSwa>>(spec, options);
}

Error Wrong(const char* field, std::string message) {
  return {ErrorCode::kInvalid, std::move(message), field};
}

int ParameterCount(const VariantSpec& spec) {
  return 2 * spec.order + 1 + (spec.affine || spec.instrumental ? 1 : 0);
}

Status Check(const VariantSpec& spec) {
  const bool sia = spec.method == EstimatorMethod::kSia;
  if (spec.order < 1 || spec.order > kOrderMax) {
    return Wrong("order", "order must be 1 to " + std::to_string(kOrderMax));
  }
  const int window_min = 2 * ParameterCount(spec);
  if (spec.window_samples < window_min || spec.window_samples > kWindowMax) {
    return Wrong("window_samples",
                 "the window K must be " + std::to_string(window_min) + " to " +
                     std::to_string(kWindowMax) + " samples");
  }
  if (sia && (spec.integral_samples < 1 || spec.integral_samples >= spec.window_samples)) {
    return Wrong("integral_samples", "the integral length m must be 1 to K - 1");
  }
  if (!sia && spec.integral_samples != 0) {
    return Wrong("integral_samples", "SWA has no integral length; leave it 0");
  }
  if (spec.instrumental && (sia || spec.order != 1)) {
    return Wrong("instrumental", "instrumental variables are offered for SWA of order 1");
  }
  if (spec.instrumental && spec.noise_sigma_v > 0.0) {
    return Wrong("noise_sigma_v", "instruments already remove the noise bias; choose one of both");
  }
  if (!(spec.noise_sigma_v >= 0.0) || !std::isfinite(spec.noise_sigma_v)) {
    return Wrong("noise_sigma_v", "the noise must be a finite voltage of at least 0");
  }
  if (!(spec.period_s > 0.0) || !std::isfinite(spec.period_s)) {
    return Wrong("period_s", "the period must be a finite time above 0");
  }
  if (!(spec.delta_s >= 0.0 && spec.delta_s <= spec.period_s)) {
    return Wrong("delta_s", "delta must lie between 0 and one period");
  }
  if (spec.sia_mode == SiaMode::kExact && (!sia || spec.order != 1)) {
    return Wrong("sia_mode", "the exact mode is defined for SIA of order 1");
  }
  return Done{};
}

}  // namespace

Result<std::unique_ptr<VariantEstimator>> MakeVariant(const VariantSpec& spec) {
  if (Status checked = Check(spec); !checked.ok()) {
    return checked.error();
  }
  return spec.instrumental ? MakeInstrumental(spec) : MakeOfOrder<1>(spec);
}

std::string Name(const VariantSpec& spec) {
  const bool sia = spec.method == EstimatorMethod::kSia;
  std::string name = sia ? "sia_" : "swa_";
  name += std::to_string(spec.window_samples);
  if (sia) {
    name.append("_").append(std::to_string(spec.integral_samples));
  }
  if (spec.order != 1) {
    name.append("_o").append(std::to_string(spec.order));
  }
  if (spec.affine) {
    name += "_affine";
  }
  if (spec.instrumental) {
    name += "_iv";
  }
  if (spec.sia_mode == SiaMode::kExact) {
    name += "_exact";
  }
  if (spec.noise_sigma_v > 0.0) {
    name += "_nc";
  }
  return name;
}

std::vector<std::string> ParameterNames(const VariantSpec& spec) {
  const std::string suffix = spec.method == EstimatorMethod::kSwa ? "d" : "";
  std::vector<std::string> names;
  for (int i = 0; i <= spec.order; ++i) {
    names.push_back(std::string("b").append(std::to_string(i)).append(suffix));
  }
  for (int i = 1; i <= spec.order; ++i) {
    names.push_back(std::string("a").append(std::to_string(i)).append(suffix));
  }
  if (spec.affine || spec.instrumental) {
    names.emplace_back("offset");
  }
  return names;
}

Result<std::vector<std::vector<VariantEstimate>>> RunStudy(std::span<const VariantSpec> specs,
                                                           std::span<const Sample> samples) {
  std::vector<std::vector<VariantEstimate>> answer;
  answer.reserve(specs.size());
  for (std::size_t i = 0; i < specs.size(); ++i) {
    Result<std::unique_ptr<VariantEstimator>> made = MakeVariant(specs[i]);
    if (!made.ok()) {
      Error error = made.error();
      error.field = std::to_string(i) + "/" + error.field;
      return error;
    }
    std::vector<VariantEstimate>& row = answer.emplace_back();
    row.reserve(samples.size());
    for (const Sample& sample : samples) {
      row.push_back(made.value()->Push(sample));
    }
  }
  return answer;
}

}  // namespace faultlab::core

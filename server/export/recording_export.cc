#include "server/export/recording_export.h"

#include <algorithm>
#include <array>
#include <boost/json/array.hpp>
#include <boost/json/object.hpp>
#include <boost/json/serialize.hpp>
#include <cmath>

#include "core/types/check.h"
#include "server/csv/csv_channels.h"
#include "server/csv/csv_writer.h"
#include "server/csv/fault_text.h"
#include "server/export/mat_file.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
constexpr std::size_t kParameters = 3;

json::value Number(double value) {
  return std::isfinite(value) ? json::value(value) : json::value(nullptr);
}

json::array Triple(const std::array<double, kParameters>& values) {
  json::array out;
  for (const double value : values) {
    out.push_back(Number(value));
  }
  return out;
}

/// An estimate that does not exist must not look like one.
core::Estimate<3> Honest(const core::Estimate<3>& estimate) {
  core::Estimate<3> out = estimate;
  if (estimate.status == core::EstimateStatus::kInvalid) {
    out.theta.fill(core::kAbsent);
    out.sigma.fill(core::kAbsent);
  }
  return out;
}

json::object EstimatorJson(std::span<const core::Frame> frames, std::size_t id) {
  json::array theta;
  json::array sigma;
  json::array status;
  for (const core::Frame& frame : frames) {
    const core::Estimate<3> estimate = Honest(frame.estimates[id]);
    theta.push_back(Triple(estimate.theta));
    sigma.push_back(Triple(estimate.sigma));
    status.emplace_back(core::Name(estimate.status));
  }
  return {{"theta", std::move(theta)}, {"sigma", std::move(sigma)}, {"status", std::move(status)}};
}

void CheckFrames(const RecordingExport& recording) {
  LAB_CHECK(recording.frames.empty() || recording.frames.size() == recording.samples.size(),
            recording.frames.size(),
            recording.samples.size());
}

}  // namespace

std::string ExportCsv(const RecordingExport& recording) {
  CsvWriteOptions options;
  options.comments = {recording.name, recording.origin};
  for (const core::Fault& fault : recording.faults) {
    options.comments.push_back(FaultComment(fault));
  }
  return FormatCsv(recording.samples, options);
}

std::string ExportJson(const RecordingExport& recording) {
  CheckFrames(recording);
  json::array faults;
  for (const core::Fault& fault : recording.faults) {
    json::object one = {{"component", core::Name(fault.component)},
                        {"value", fault.value},
                        {"unit", core::Unit(fault.component)},
                        {"at_s", fault.at_s},
                        {"kind", core::Name(fault.kind)}};
    if (fault.kind != core::FaultKind::kAbrupt) {
      one["until_s"] = fault.until_s;
    }
    faults.push_back(std::move(one));
  }
  json::object samples;
  json::array index;
  for (const core::Sample& sample : recording.samples) {
    index.emplace_back(sample.index);
  }
  samples["index"] = std::move(index);
  for (const CsvChannel& channel : kCsvChannelTable) {
    json::array column;
    column.reserve(recording.samples.size());
    for (const core::Sample& sample : recording.samples) {
      column.push_back(Number(sample.*channel.member));
    }
    samples[channel.name] = std::move(column);
  }
  json::object estimates;
  for (std::size_t id = 0; id < core::kEstimatorCount && !recording.frames.empty(); ++id) {
    estimates[core::kEstimatorShapes[id].name] = EstimatorJson(recording.frames, id);
  }
  return json::serialize(json::object{{"name", recording.name},
                                      {"origin", recording.origin},
                                      {"period_s", recording.period_s},
                                      {"faults", std::move(faults)},
                                      {"samples", std::move(samples)},
                                      {"estimates", std::move(estimates)},
                                      {"diagnosis", recording.diagnosis}}) +
         "\n";
}

std::string ExportMat(const RecordingExport& recording) {
  CheckFrames(recording);
  MatFile file("MATLAB 5.0 MAT-file, faultlab recording");
  const std::size_t count = recording.samples.size();
  std::vector<double> column(count);
  for (const CsvChannel& channel : kCsvChannelTable) {
    std::transform(recording.samples.begin(),
                   recording.samples.end(),
                   column.begin(),
                   [&](const core::Sample& sample) { return sample.*channel.member; });
    file.AddColumn(channel.name, column);
  }
  std::transform(recording.samples.begin(),
                 recording.samples.end(),
                 column.begin(),
                 [](const core::Sample& sample) { return static_cast<double>(sample.index); });
  file.AddColumn("sample_index", column);
  file.AddScalar("period_s", recording.period_s);
  for (std::size_t id = 0; id < core::kEstimatorCount && !recording.frames.empty(); ++id) {
    std::vector<double> theta(kParameters * count);
    std::vector<double> sigma(kParameters * count);
    std::vector<double> status(count);
    for (std::size_t k = 0; k < count; ++k) {
      const core::Estimate<3> estimate = Honest(recording.frames[k].estimates[id]);
      for (std::size_t p = 0; p < kParameters; ++p) {
        theta[p * count + k] = estimate.theta[p];
        sigma[p * count + k] = estimate.sigma[p];
      }
      status[k] = static_cast<double>(estimate.status);
    }
    const std::string name(core::kEstimatorShapes[id].name);
    file.AddMatrix(name, theta, count, kParameters);
    file.AddMatrix(name + "_sigma", sigma, count, kParameters);
    file.AddColumn(name + "_status", status);
  }
  file.AddText("name", recording.name);
  file.AddText("origin", recording.origin);
  file.AddText("diagnosis_json",
               recording.diagnosis.is_null() ? "" : json::serialize(recording.diagnosis));
  return std::move(file).Take();
}

}  // namespace faultlab::server

#include "server/export/recording_export.h"

#include <algorithm>
#include <array>
#include <boost/json/serialize.hpp>
#include <charconv>
#include <cmath>
#include <string_view>
#include <vector>

#include "core/types/check.h"
#include "server/csv/csv_channels.h"
#include "server/export/mat_file.h"

namespace faultlab::server {
namespace {

constexpr std::size_t kParameters = 3;
constexpr std::size_t kColumnsPerEstimator = 2 * kParameters + 1;  ///< theta, sigma, status
constexpr std::size_t kNumbersPerPiece = 4096;

/// One column of numbers on its way to its place in a file.
class ColumnWriter {
 public:
  ColumnWriter(Spool& out, std::uint64_t at) : out_(&out), at_(at) {}

  void Add(double value) {
    waiting_.push_back(value);
    if (waiting_.size() == kNumbersPerPiece) Flush();
  }
  void Flush() {
    const std::size_t bytes = waiting_.size() * sizeof(double);
    out_->WriteAt(at_, {reinterpret_cast<const char*>(waiting_.data()), bytes});
    at_ += bytes;
    waiting_.clear();
  }

 private:
  Spool* out_;
  std::uint64_t at_;
  std::vector<double> waiting_;
};

void AddMatrixColumns(std::vector<ColumnWriter>& columns,
                      MatFile& file,
                      Spool& out,
                      const std::string& name,
                      std::size_t rows,
                      std::size_t count) {
  const std::uint64_t at = file.ReserveMatrix(name, rows, count);
  for (std::size_t i = 0; i < count; ++i) columns.emplace_back(out, at + i * rows * sizeof(double));
}

void WriteEstimates(const RecordingExport& recording, MatFile& file, Spool& out) {
  const std::size_t rows = recording.samples.size();
  std::vector<ColumnWriter> columns;
  for (const core::EstimatorShape& shape : core::kEstimatorShapes) {
    const std::string name(shape.name);
    AddMatrixColumns(columns, file, out, name, rows, kParameters);
    AddMatrixColumns(columns, file, out, name + "_sigma", rows, kParameters);
    AddMatrixColumns(columns, file, out, name + "_status", rows, 1);
  }
  std::size_t frames = 0;
  recording.each_frame([&](const core::Frame& frame) {
    LAB_CHECK(++frames <= rows, frames, rows);
    for (std::size_t id = 0; id < core::kEstimatorCount; ++id) {
      const core::Estimate<3> estimate = core::Shown(frame.estimates[id]);
      ColumnWriter* column = &columns[id * kColumnsPerEstimator];
      for (const double value : estimate.theta) (column++)->Add(value);
      for (const double value : estimate.sigma) (column++)->Add(value);
      column->Add(static_cast<double>(estimate.status));
    }
  });
  LAB_CHECK(frames == rows, frames, rows);
  for (ColumnWriter& column : columns) column.Flush();
}

void AppendCell(std::string& line, double value) {
  line += ',';
  if (!std::isfinite(value)) return;
  std::array<char, 32> text;
  line.append(text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr);
}

std::string EstimatesHead() {
  std::string head = "index,t_s";
  for (const core::EstimatorShape& shape : core::kEstimatorShapes) {
    const std::string name = "," + std::string(shape.name) + "_";
    const char* suffix = shape.integral_samples == 0 ? "d" : "";
    constexpr std::array<std::string_view, kParameters> kNames = {"b0", "b1", "a1"};
    for (const std::string_view parameter : kNames) {
      head.append(name).append(parameter).append(suffix);
    }
    for (const std::string_view parameter : kNames) {
      head.append(name).append(parameter).append(suffix).append("_sigma");
    }
    head.append(name).append("status");
  }
  return head + "\n";
}

}  // namespace

void WriteEstimatesCsv(const RecordingExport& recording, Spool& out) {
  out.Append("# " + recording.origin + ": estimates\n" + EstimatesHead());
  std::string piece;
  recording.each_frame([&](const core::Frame& frame) {
    piece += std::to_string(frame.sample.index);
    AppendCell(piece, frame.sample.t_s);
    for (const core::Estimate<3>& estimate : frame.estimates) {
      const core::Estimate<3> shown = core::Shown(estimate);
      for (const double value : shown.theta) AppendCell(piece, value);
      for (const double value : shown.sigma) AppendCell(piece, value);
      piece.append(",").append(core::Name(estimate.status));
    }
    piece += '\n';
    constexpr std::size_t kPieceBytes = 16 << 10;
    if (piece.size() < kPieceBytes) return;
    out.Append(piece);
    piece.clear();
  });
  out.Append(piece);
}

void WriteMat(const RecordingExport& recording, Spool& out) {
  MatFile file(out, "MATLAB 5.0 MAT-file, faultlab recording");
  std::vector<double> column(recording.samples.size());
  for (const CsvChannel& channel : kCsvChannelTable) {
    std::ranges::transform(recording.samples, column.begin(), [&](const core::Sample& sample) {
      return sample.*channel.member;
    });
    file.AddColumn(channel.name, column);
  }
  std::ranges::transform(recording.samples, column.begin(), [](const core::Sample& sample) {
    return static_cast<double>(sample.index);
  });
  file.AddColumn("sample_index", column);
  file.AddScalar("period_s", recording.period_s);
  WriteEstimates(recording, file, out);
  file.AddText("name", recording.name);
  file.AddText("origin", recording.origin);
  file.AddText("story", recording.story);
  file.AddText("diagnosis_json",
               recording.diagnosis.is_null() ? "" : boost::json::serialize(recording.diagnosis));
}

}  // namespace faultlab::server

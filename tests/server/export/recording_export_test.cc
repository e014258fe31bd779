#include "server/export/recording_export.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <matio.h>

#include <unistd.h>

#include <boost/json/parse.hpp>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>

#include "core/types/check.h"
#include "server/csv/csv_record.h"
#include "server/export/mat_file.h"
#include "tests/support/paths.h"

namespace faultlab::server {
namespace {

namespace fs = std::filesystem;
namespace json = boost::json;

/// Three samples, the middle one without a current; the estimates encode sample and parameter.
class RecordingExportTest : public ::testing::Test {
 protected:
  RecordingExportTest() {
    for (int k = 0; k < 3; ++k) {
      core::Frame frame;
      frame.sample.index = k;
      frame.sample.t_s = 0.01 * k;
      frame.sample.uc_v = 2.0 + k;
      frame.sample.um_v = 0.1 + 1.0 / (k + 3);
      frame.sample.ia_a = k == 1 ? core::kAbsent : 0.25 * k;
      for (core::Estimate<3>& estimate : frame.estimates) {
        estimate.status = core::EstimateStatus::kExcited;
        estimate.theta = {10.0 * k, 10.0 * k + 1, 10.0 * k + 2};
        estimate.sigma = {0.5, 0.6, 0.7};
      }
      frame.estimates[0].status =
          k == 0 ? core::EstimateStatus::kInvalid : core::EstimateStatus::kWeak;
      frames_.push_back(frame);
      samples_.push_back(frame.sample);
    }
    recording_.name = "R1 = 100 Ω";
    recording_.origin = "rig sim-1";
    recording_.period_s = 0.01;
    recording_.samples = samples_;
    recording_.each_frame = [this](const std::function<void(const core::Frame&)>& each) {
      for (const core::Frame& frame : frames_) each(frame);
    };
    recording_.diagnosis = json::object{{"verdict", "fault"}};
  }

  std::vector<core::Sample> samples_;
  std::vector<core::Frame> frames_;
  RecordingExport recording_;
};

/// A variable as libmatio reads it.
class MatVariable {
 public:
  MatVariable(mat_t* file, const char* name) : variable_(Mat_VarRead(file, name)) {}
  MatVariable(const MatVariable&) = delete;
  MatVariable& operator=(const MatVariable&) = delete;
  ~MatVariable() { Mat_VarFree(variable_); }
  const matvar_t* operator->() const { return variable_; }
  bool ok() const { return variable_ != nullptr; }
  double at(std::size_t i) const { return static_cast<const double*>(variable_->data)[i]; }

 private:
  matvar_t* variable_;
};

/// No MATLAB is at hand to run it.
TEST_F(RecordingExportTest, TheExampleInMatlabReadsVariablesThatAreThere) {
  Spool out({.folder = fs::temp_directory_path()});
  WriteMat(recording_, out);
  const std::string file = std::move(out).TakeMemory();
  std::ifstream in(tests::InSource("deploy/examples/load_run.m"));
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  static const std::regex kUsed(R"(run\.([A-Za-z0-9_]+))");
  int used = 0;
  for (std::sregex_iterator at(text.begin(), text.end(), kUsed), end; at != end; ++at, ++used) {
    EXPECT_NE(file.find((*at)[1].str()), std::string::npos) << at->str();
  }
  EXPECT_GT(used, 5);
}

TEST_F(RecordingExportTest, WritesAMatFileThatLibmatioReads) {
  const fs::path path = fs::temp_directory_path() / ("faultlab-" + std::to_string(::getpid()));
  Spool out({.folder = fs::temp_directory_path()});
  WriteMat(recording_, out);
  ASSERT_TRUE(out.in_memory());
  std::ofstream(path, std::ios::binary) << std::move(out).TakeMemory();
  mat_t* file = Mat_Open(path.c_str(), MAT_ACC_RDONLY);
  fs::remove(path);
  ASSERT_NE(file, nullptr);
  EXPECT_EQ(Mat_GetVersion(file), MAT_FT_MAT5);
  {
    const MatVariable um(file, "um_v");
    ASSERT_TRUE(um.ok());
    ASSERT_EQ(um->dims[0], 3u);
    ASSERT_EQ(um->dims[1], 1u);
    EXPECT_EQ(um.at(2), samples_[2].um_v);
    const MatVariable ia(file, "ia_a");
    ASSERT_TRUE(ia.ok());
    EXPECT_TRUE(std::isnan(ia.at(1)));
    const MatVariable period(file, "period_s");
    ASSERT_TRUE(period.ok());
    EXPECT_EQ(period.at(0), 0.01);
    const MatVariable swa(file, "swa_100");
    ASSERT_TRUE(swa.ok());
    ASSERT_EQ(swa->dims[0], 3u);
    ASSERT_EQ(swa->dims[1], 3u);
    EXPECT_EQ(swa.at(2), 20.0) << "column-major: b0d of the third sample";
    EXPECT_EQ(swa.at(3), 1.0) << "b1d of the first sample";
    const MatVariable invalid(file, "swa_50");
    ASSERT_TRUE(invalid.ok());
    EXPECT_TRUE(std::isnan(invalid.at(0)));
    const MatVariable name(file, "name");
    ASSERT_TRUE(name.ok());
    EXPECT_EQ(name->class_type, MAT_C_CHAR);
    EXPECT_EQ(name->dims[1], 10u) << "letters, not bytes";
  }
  Mat_Close(file);
}

TEST(WriteMat, WritesALongRecordingToTheDiskAsItWouldAShortOne) {
  constexpr int kSamples = 20'000;
  std::vector<core::Sample> samples(kSamples);
  for (int k = 0; k < kSamples; ++k) {
    samples[static_cast<std::size_t>(k)].index = k;
    samples[static_cast<std::size_t>(k)].um_v = 0.5 * k;
  }
  RecordingExport recording;
  recording.samples = samples;
  recording.each_frame = [&](const std::function<void(const core::Frame&)>& each) {
    for (const core::Sample& sample : samples) {
      core::Frame frame;
      frame.sample = sample;
      for (core::Estimate<3>& estimate : frame.estimates) {
        estimate.status = core::EstimateStatus::kExcited;
        estimate.theta = {1.0 * static_cast<double>(sample.index), 2.0, 3.0};
      }
      each(frame);
    }
  };
  Spool out({.folder = fs::temp_directory_path()});
  WriteMat(recording, out);
  ASSERT_TRUE(out.status().ok());
  ASSERT_FALSE(out.in_memory());
  const fs::path path = fs::temp_directory_path() / ("faultlab-long-" + std::to_string(::getpid()));
  {
    std::ofstream copy(path, std::ios::binary);
    for (std::uint64_t at = 0; at < out.size();) {
      const auto piece = out.Read(at, 100'000);
      ASSERT_TRUE(piece && !piece->empty());
      copy << *piece;
      at += piece->size();
    }
  }
  mat_t* file = Mat_Open(path.c_str(), MAT_ACC_RDONLY);
  fs::remove(path);
  ASSERT_NE(file, nullptr);
  {
    const MatVariable um(file, "um_v");
    ASSERT_TRUE(um.ok());
    EXPECT_EQ(um.at(kSamples - 1), 0.5 * (kSamples - 1));
    const MatVariable sia(file, "sia_500_20");
    ASSERT_TRUE(sia.ok());
    ASSERT_EQ(sia->dims[0], static_cast<std::size_t>(kSamples));
    EXPECT_EQ(sia.at(kSamples - 1), kSamples - 1.0);
    EXPECT_EQ(sia.at(kSamples), 2.0);
    EXPECT_EQ(sia.at(3 * kSamples - 1), 3.0);
  }
  Mat_Close(file);
}

TEST(Spool, SaysThatTheDiskIsFull) {
  Spool out({.folder = "/proc/no/such/folder"});
  out.Append("short");
  EXPECT_TRUE(out.status().ok());
  out.Append(std::string(Spool::kMemoryMax, 'x'));
  ASSERT_FALSE(out.status().ok());
  EXPECT_EQ(out.status().error().reason, "disk_full");
  out.Append("more");
}

TEST(Spool, LeavesTheReserveOfTheDiskFree) {
  Spool out({.folder = fs::temp_directory_path(), .bytes = std::int64_t{1} << 60});
  out.Append(std::string(Spool::kMemoryMax + 1, 'x'));
  ASSERT_FALSE(out.status().ok());
  EXPECT_EQ(out.status().error().reason, "disk_full");
}

TEST(MatFile, RefusesANameThatMatlabCannotHave) {
  Spool out({});
  MatFile file(out, "");
  EXPECT_THROW(file.AddScalar("1st", 0.0), core::ContractError);
  EXPECT_THROW(file.AddScalar("a b", 0.0), core::ContractError);
  EXPECT_THROW(file.AddScalar(std::string(64, 'a'), 0.0), core::ContractError);
  EXPECT_THROW(file.AddMatrix("m", {}, 1, 1), core::ContractError);
}

}  // namespace
}  // namespace faultlab::server

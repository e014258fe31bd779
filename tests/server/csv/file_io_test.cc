#include "server/csv/file_io.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "server/csv/csv_record.h"

namespace faultlab::server {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class FileIo : public ::testing::Test {
 protected:
  FileIo() {
    std::string pattern = (fs::temp_directory_path() / "faultlab-io-XXXXXX").string();
    folder_ = ::mkdtemp(pattern.data());
  }
  ~FileIo() override { fs::remove_all(folder_); }

  std::string Path(const std::string& name) const { return (folder_ / name).string(); }
  static std::string Slurp(const std::string& path) {
    std::ostringstream text;
    text << std::ifstream(path, std::ios::binary).rdbuf();
    return text.str();
  }
  std::size_t FilesInFolder() const {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }

  fs::path folder_;
};

constexpr std::size_t kPlenty = 1 << 20;

TEST_F(FileIo, WritesAndReadsBackPlainAndGzipFiles) {
  const std::string text(100'000, 'x');
  ASSERT_TRUE(WriteFile(Path("a.csv"), text));
  ASSERT_TRUE(WriteFile(Path("a.csv.gz"), text));
  EXPECT_EQ(Slurp(Path("a.csv")), text);
  EXPECT_LT(fs::file_size(Path("a.csv.gz")), 1000u);
  EXPECT_EQ(ReadFile(Path("a.csv.gz"), kPlenty).value(), text);
  EXPECT_EQ(FilesInFolder(), 2u) << "no temporary file stays";
}

TEST_F(FileIo, ReadsAGzipFileOfSeveralMembers) {
  std::ofstream(Path("two.gz"), std::ios::binary) << Gzip("first ") << Gzip("second");
  EXPECT_EQ(ReadFile(Path("two.gz"), kPlenty).value(), "first second");
}

TEST_F(FileIo, RefusesCutDamagedAndEmptyGzipFiles) {
  const std::string good = Gzip(std::string(5000, 'q') + "tail");
  for (const std::string& bad : {good.substr(0, good.size() - 5),
                                 good.substr(0, 12),
                                 std::string(),
                                 std::string("t_s,uc_v\n"),
                                 good + "rubbish"}) {
    std::ofstream(Path("bad.gz"), std::ios::binary) << bad;
    const core::Result<std::string> read = ReadFile(Path("bad.gz"), kPlenty);
    ASSERT_FALSE(read) << bad.size();
    EXPECT_THAT(read.error().message, HasSubstr("bad.gz: damaged or cut gzip data"));
  }
}

TEST_F(FileIo, StopsInflatingAtTheLimit) {
  ASSERT_TRUE(WriteFile(Path("bomb.gz"), std::string(50 << 20, '0')));
  const core::Result<std::string> read = ReadFile(Path("bomb.gz"), kPlenty);
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().code, core::ErrorCode::kTooLarge);
}

TEST_F(FileIo, SaysWhyAFileCannotBeRead) {
  const core::Result<std::string> missing = ReadFile(Path("none.csv"), kPlenty);
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, core::ErrorCode::kNotFound);
  EXPECT_THAT(missing.error().message, HasSubstr("none.csv: No such file or directory"));
  EXPECT_THAT(ReadFile(folder_.string(), kPlenty).error().message, HasSubstr("Is a directory"));
}

TEST_F(FileIo, LeavesTheOldFileWhenTheDiskIsFull) {
  const core::Status full = WriteFile("/dev/full", "text");
  ASSERT_FALSE(full);
  EXPECT_THAT(full.error().message, HasSubstr("No space left on device"));
  ASSERT_TRUE(WriteFile(Path("kept.csv"), "old"));
  fs::create_directory(Path("target.csv"));
  EXPECT_FALSE(WriteFile(Path("target.csv"), "new"));
  EXPECT_FALSE(WriteFile(Path("no/such/folder.csv"), "new"));
  EXPECT_EQ(Slurp(Path("kept.csv")), "old");
  EXPECT_EQ(FilesInFolder(), 2u);
}

}  // namespace
}  // namespace faultlab::server

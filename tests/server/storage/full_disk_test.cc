// A real full disk: a tmpfs of a few megabytes in a mount namespace of this process.
#include <gmock/gmock.h>
#include <libpq-fe.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "server/storage/recording_store.h"
#include "tests/support/postgres_cluster.h"
#include "tests/support/temp_folder.h"

namespace faultlab::server {
namespace {

namespace fs = std::filesystem;
using ::testing::AnyOf;
using ::testing::HasSubstr;

/// Mounted while the object exists. `mounted()` is false where this process may not mount.
class SmallDisk {
 public:
  explicit SmallDisk(int megabytes) {
    const bool alone =
        unshare(CLONE_NEWNS) == 0 && mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0;
    const std::string options = "size=" + std::to_string(megabytes) + "m";
    mounted_ = alone && mount("tmpfs", path().c_str(), "tmpfs", 0, options.c_str()) == 0;
  }
  ~SmallDisk() {
    if (mounted_) umount2(path().c_str(), MNT_DETACH);
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;
  bool mounted() const { return mounted_; }
  std::string path() const { return folder_.path().string(); }

 private:
  tests::TempFolder folder_;
  bool mounted_ = false;
};

RunRecord Run(const std::string& id) {
  RunRecord record;
  record.id = id;
  record.owner = "user:1";
  record.source = "run";
  return record;
}

/// Stores chunks of a run until the disk is full; returns how many were stored.
std::int64_t FillWithChunks(RecordingStore& store, const std::string& run, core::Status& refusal) {
  std::vector<core::Sample> samples(1000);
  std::int64_t stored = 0;
  for (; refusal.ok() && stored < 100'000; ++stored) {
    for (std::size_t i = 0; i < samples.size(); ++i) {
      samples[i].index = stored * 1000 + static_cast<std::int64_t>(i);
      samples[i].um_v = static_cast<double>(samples[i].index) * 0.7312;
    }
    refusal = store.AppendChunk(run, samples.front().index, samples);
    if (!refusal.ok()) break;
  }
  return stored;
}

/// Fills the disk, checks that everything answered is stored, frees space by `free`, checks that it
/// continues.
template <typename Free>
void FillFreeAndGoOn(Database& database, const Free& free) {
  RecordingStore store(database);
  ASSERT_TRUE(store.Begin(Run("run-1")).ok());
  core::Status refusal = core::Done{};
  const std::int64_t stored = FillWithChunks(store, "run-1", refusal);
  ASSERT_FALSE(refusal.ok());
  EXPECT_EQ(refusal.error().code, core::ErrorCode::kUnavailable);
  EXPECT_THAT(refusal.error().message, AnyOf(HasSubstr("is full"), HasSubstr("No space left")));
  EXPECT_GT(stored, 5);
  const auto samples = store.LoadSamples("run-1", 0, 1'000'000'000);
  ASSERT_TRUE(samples.ok()) << samples.error().message;
  EXPECT_EQ(static_cast<std::int64_t>(samples.value().size()), stored * 1000);
  EXPECT_DOUBLE_EQ(samples.value().back().um_v, static_cast<double>(stored * 1000 - 1) * 0.7312);
  EXPECT_TRUE(database.Check().ok());

  free();
  core::Status again = core::Done{};
  EXPECT_TRUE(store.Finish("run-1", RunState::kStopped, WallTime{}, "{}", "nominal").ok());
  EXPECT_TRUE(store.Begin(Run("run-2")).ok());
  EXPECT_TRUE(store.AppendChunk("run-2", 0, std::vector<core::Sample>(1)).ok());
  EXPECT_EQ(store.Get("run-1").value().samples, stored * 1000) << "nothing was lost";
}

TEST(FullDisk, OnSqliteIsSaidNothingIsLostAndItGoesOnWhenThereIsSpace) {
  const SmallDisk disk(4);
  if (!disk.mounted()) GTEST_SKIP() << "this process may not mount";
  const std::string ballast = disk.path() + "/ballast";
  std::ofstream(ballast) << std::string(1 << 20, 'x');
  auto database = Database::Open({.location = disk.path() + "/faultlab.db"}).value();
  FillFreeAndGoOn(*database, [&] { fs::remove(ballast); });
}

TEST(FullDisk, AtTheStartIsAClearSentence) {
  const SmallDisk disk(1);
  if (!disk.mounted()) GTEST_SKIP() << "this process may not mount";
  std::ofstream(disk.path() + "/ballast") << std::string(1 << 20, 'x');
  const auto opened = Database::Open({.location = disk.path() + "/faultlab.db"});
  ASSERT_FALSE(opened.ok());
  EXPECT_THAT(opened.error().message,
              AnyOf(HasSubstr("full"), HasSubstr("cannot be opened"), HasSubstr("disk")));
}

/// Executes one statement on a separate connection; returns the first value of the answer.
std::string Sql(const std::string& connection, const std::string& statement) {
  PGconn* link = PQconnectdb(connection.c_str());
  PGresult* result = PQexec(link, statement.c_str());
  const ExecStatusType status = PQresultStatus(result);
  EXPECT_TRUE(status == PGRES_COMMAND_OK || status == PGRES_TUPLES_OK) << PQerrorMessage(link);
  const std::string value = PQntuples(result) > 0 ? PQgetvalue(result, 0, 0) : "";
  PQclear(result);
  PQfinish(link);
  return value;
}

TEST(FullDisk, OnPostgresqlIsSaidNothingIsLostAndItGoesOnWhenThereIsSpace) {
  // Before the cluster starts, so that the cluster uses this disk.
  const SmallDisk disk(32);
  if (!disk.mounted()) GTEST_SKIP() << "this process may not mount";
  const std::string location = tests::PostgresCluster::Instance().CreateDatabase();
  const std::string connection = location.substr(location.find(':') + 1);
  struct stat owner {};
  ASSERT_EQ(stat(Sql(connection, "SHOW data_directory").c_str(), &owner), 0);
  const std::string space = disk.path() + "/space";
  fs::create_directory(space);
  fs::permissions(disk.path(), fs::perms::all);
  ASSERT_EQ(chown(space.c_str(), owner.st_uid, owner.st_gid), 0);
  const std::string ballast = disk.path() + "/ballast";
  std::ofstream(ballast) << std::string(4 << 20, 'x');
  const std::string name = Sql(connection, "SELECT current_database()");
  Sql(connection, "CREATE TABLESPACE small LOCATION '" + space + "'");
  Sql(connection + " dbname=postgres", "ALTER DATABASE \"" + name + "\" SET TABLESPACE small");
  auto database = Database::Open({.location = location}).value();
  FillFreeAndGoOn(*database, [&] { fs::remove(ballast); });
  database.reset();
  Sql(connection + " dbname=postgres", "DROP DATABASE \"" + name + "\" WITH (FORCE)");
  Sql(connection + " dbname=postgres", "DROP TABLESPACE small");
}

}  // namespace
}  // namespace faultlab::server

#include "server/storage/database.h"

#include <gmock/gmock.h>
#include <soci/soci.h>
#include <sqlite3.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <stdexcept>
#include <thread>

#include "server/storage/blob_store.h"
#include "server/storage/postgres_location.h"
#include "server/storage/rows.h"
#include "tests/support/engines.h"
#include "tests/support/postgres_cluster.h"
#include "tests/support/test_database.h"

namespace faultlab::server {
namespace {

using core::Done;
using core::ErrorCode;
using core::Status;
using testing::HasSubstr;

Status PutBytes(Database& database, std::int64_t sequence, std::size_t size) {
  return database.Write(Durability::kPromise, [&](Transaction& tx) -> Status {
    blob_store::Put(tx, "bytes", sequence, Bytes(size, std::byte{1}));
    return Done{};
  });
}

std::int64_t CountBlobs(Database& database) {
  return database
      .Read([](Transaction& tx) -> core::Result<std::int64_t> {
        std::int64_t count = 0;
        tx.sql() << "SELECT COUNT(*) FROM blob_store", soci::into(count);
        return count;
      })
      .value();
}

class DatabaseOnBoth : public testing::TestWithParam<Engine> {
 protected:
  tests::TestDatabase database_{GetParam()};
};

TEST_P(DatabaseOnBoth, TakesBodiesThatReturnNothingOrAPlainValue) {
  const Status put = database_->Write(
      Durability::kPromise, [](Transaction& tx) { blob_store::Put(tx, "bytes", 1, Bytes(3)); });
  EXPECT_TRUE(put.ok());
  const core::Result<std::int64_t> changed = database_->Write(
      Durability::kPromise,
      [](Transaction& tx) { return Execute(tx, "UPDATE blob_store SET seq = seq"); });
  EXPECT_EQ(changed.value(), 1);
  const core::Result<std::int64_t> count =
      database_->Read([](Transaction& tx) { return CountRows(tx, "blob_store"); });
  EXPECT_EQ(count.value(), 1);
  const Status failed = database_->Write(Durability::kPromise, [](Transaction& tx) {
    blob_store::Put(tx, "bytes", 2, Bytes(3));
    throw std::runtime_error("in the middle");
  });
  EXPECT_FALSE(failed.ok());
  EXPECT_EQ(CountBlobs(*database_), 1);
}

TEST_P(DatabaseOnBoth, BindsByNameHoweverOftenAndInWhateverOrder) {
  const Status status = database_->Write(Durability::kPromise, [](Transaction& tx) {
    EXPECT_EQ(InsertInto(tx, "course", {{"name", "b"}, {"created_ms", 2}}), 1);
    const std::int64_t id = AddInto(tx, "course", {{"created_ms", 5}, {"name", "a"}});
    EXPECT_EQ(CountRows(tx,
                        "course WHERE name = :name AND created_ms > :least OR name = :name AND id "
                        "= :id",
                        {{"id", id}, {"least", 9}, {"name", "a"}}),
              1);
    // A column may be both what is set and what is asked for.
    EXPECT_EQ(UpdateWhere(tx, "course", {{"name", "c"}}, {{"name", "a"}, {"created_ms", 5}}), 1);
    EXPECT_EQ(UpdateWhere(tx, "course", {{"name", "c"}}, {{"name", "a"}}), 0);
    Condition which;
    which.And("created_ms < :most", {{"most", FromMilliseconds(9)}});
    const auto rows = SelectTuples<std::string, WallTime, bool>(
        tx,
        "SELECT name, created_ms, ends_ms FROM course WHERE " + which.sql + " ORDER BY name",
        which.parameters);
    using Row = std::tuple<std::string, WallTime, bool>;
    EXPECT_THAT(rows,
                testing::ElementsAre(Row("b", FromMilliseconds(2), false),
                                     Row("c", FromMilliseconds(5), false)));
    EXPECT_EQ(SelectValue<int>(tx, "SELECT id FROM course WHERE name = 'none'"), std::nullopt);
    EXPECT_EQ(DeleteFrom(tx, "course", {{"name", "c"}, {"id", id}}), 1);
  });
  EXPECT_TRUE(status.ok());
}

TEST_P(DatabaseOnBoth, RollsBackWhenTheBodyThrows) {
  const Status status = database_->Write(Durability::kPromise, [](Transaction& tx) -> Status {
    blob_store::Put(tx, "bytes", 1, Bytes(3));
    throw std::runtime_error("in the middle");
  });
  ASSERT_FALSE(status.ok());
  EXPECT_THAT(status.error().message, testing::Not(HasSubstr("in the middle")))
      << "the engine's words are the operator's";
  EXPECT_EQ(CountBlobs(*database_), 0);
}

TEST(DatabaseErrors, AreToldToTheLogInTheEnginesWordsAndToPeopleInOurs) {
  tests::TempFolder folder;
  std::string told;
  const auto database =
      Database::Open({.location = folder.File("test.db"),
                      .on_error = [&told](std::string_view text) { told += text; }});
  ASSERT_TRUE(database.ok());
  const Status status =
      database.value()->Write(Durability::kPromise, [](Transaction& tx) -> Status {
        tx.sql() << "INSERT INTO no_such_table (secret) VALUES ('of a person')";
        return Done{};
      });
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().message, "the database refused");
  EXPECT_THAT(told, HasSubstr("no_such_table"));
}

TEST_P(DatabaseOnBoth, KeepsWhatWasCommittedOverAReopen) {
  ASSERT_TRUE(PutBytes(*database_, 1, 10).ok());
  database_.Reopen();
  EXPECT_EQ(CountBlobs(*database_), 1);
}

TEST_P(DatabaseOnBoth, LetsManyWritersTakeTurnsWithoutLosingOne) {
  constexpr int kWriters = 8;
  constexpr int kEach = 20;
  auto second_server = database_.OpenAnother();
  std::vector<std::thread> writers;
  std::atomic<int> failed = 0;
  for (int w = 0; w < kWriters; ++w) {
    writers.emplace_back([&, w] {
      Database& database = w % 2 == 0 ? *database_ : *second_server;
      for (int i = 0; i < kEach; ++i) {
        if (!PutBytes(database, w * 1000 + i, 100).ok()) ++failed;
      }
    });
  }
  for (auto& writer : writers) writer.join();
  EXPECT_EQ(failed, 0);
  EXPECT_EQ(CountBlobs(*database_), kWriters * kEach);
}

TEST(SqliteDatabase, ServesWritersInTheOrderInWhichTheyCame) {
  tests::TestDatabase database(Engine::kSqlite);
  std::atomic<bool> stop{false};
  std::atomic<int> writes{0};
  std::vector<std::thread> greedy;
  for (int i = 0; i < 8; ++i) {
    greedy.emplace_back([&] {
      while (!stop) {
        (void)database->Write(Durability::kPromise, [&](Transaction& tx) -> Status {
          ++writes;
          int counted = 0;  // some milliseconds of work, in which the others come to wait
          tx.sql()
              << "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < 20000) "
                 "SELECT count(*) FROM n",
              soci::into(counted);
          return counted == 20000 ? Status(Done{}) : core::Refuse("nothing_here");
        });
      }
    });
  }
  std::vector<int> before_ours;
  for (int i = 0; i < 60; ++i) {
    const int before = writes;
    ASSERT_TRUE(PutBytes(*database, i, 10).ok());
    before_ours.push_back(writes - before);
  }
  stop = true;
  for (std::thread& thread : greedy) thread.join();
  std::sort(before_ours.begin(), before_ours.end());
  // The eight that waited before, and one at work; in any order it would be 18.
  EXPECT_LE(before_ours[54], 10);
}

TEST_P(DatabaseOnBoth, FindsNoDamageInAHealthyDatabase) {
  ASSERT_TRUE(PutBytes(*database_, 1, 100000).ok());
  const Status status = database_->Check();
  EXPECT_TRUE(status.ok()) << status.error().message;
}

INSTANTIATE_TEST_SUITE_P(Engines, DatabaseOnBoth, tests::kBothEngines, tests::EngineName);

TEST(SqliteDatabase, SaysThatTheDiskIsFullAndKeepsEverythingBefore) {
  tests::TempFolder folder;
  auto database =
      Database::Open({.location = folder.File("small.db"), .bytes_max = 800 << 10}).value();
  std::int64_t stored = 0;
  Status status = Done{};
  while (status.ok() && stored < 1000) {
    status = PutBytes(*database, stored, 10000);
    if (status.ok()) ++stored;
  }
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().code, ErrorCode::kUnavailable);
  EXPECT_THAT(status.error().message, HasSubstr("full"));
  EXPECT_GT(stored, 10);
  EXPECT_EQ(CountBlobs(*database), stored);
  EXPECT_TRUE(database->Check().ok());
  ASSERT_TRUE(database
                  ->Write(Durability::kPromise,
                          [](Transaction& tx) -> Status {
                            blob_store::Erase(tx, "bytes");
                            return Done{};
                          })
                  .ok());
  EXPECT_TRUE(PutBytes(*database, 1, 10000).ok()) << "works again once there is space";
}

TEST(SqliteDatabase, SaysThatAnotherProgramHoldsTheLock) {
  tests::TempFolder folder;
  const std::string file = folder.File("locked.db");
  auto database =
      Database::Open({.location = file, .patience = std::chrono::milliseconds(20)}).value();
  sqlite3* intruder = nullptr;
  ASSERT_EQ(sqlite3_open(file.c_str(), &intruder), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(intruder, "BEGIN IMMEDIATE", nullptr, nullptr, nullptr), SQLITE_OK);
  const Status locked = PutBytes(*database, 1, 10);
  EXPECT_EQ(CountBlobs(*database), 0) << "readers go on";
  sqlite3_close(intruder);
  ASSERT_FALSE(locked.ok());
  EXPECT_EQ(locked.error().code, ErrorCode::kBusy);
  EXPECT_THAT(locked.error().message, HasSubstr("locked"));
  EXPECT_TRUE(PutBytes(*database, 1, 10).ok());
}

TEST(SqliteDatabase, SaysThatAFileIsNoDatabase) {
  tests::TempFolder folder;
  std::ofstream(folder.File("text.db")) << std::string(8192, 'x');
  const auto opened = Database::Open({.location = folder.File("text.db")});
  ASSERT_FALSE(opened.ok());
  EXPECT_EQ(opened.error().code, ErrorCode::kUnavailable);
  EXPECT_THAT(opened.error().message, HasSubstr("damaged"));
}

TEST(SqliteDatabase, OfAnotherProgramIsRefusedAndStaysAsItIs) {
  tests::TempFolder folder;
  const std::string file = folder.File("shop.db");
  sqlite3* shop = nullptr;
  ASSERT_EQ(sqlite3_open(file.c_str(), &shop), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(shop, "CREATE TABLE goods (id INTEGER)", nullptr, nullptr, nullptr), 0);
  sqlite3_close(shop);
  const auto bytes = [&] {
    std::ifstream in(file, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  const std::string before = bytes();
  const auto opened = Database::Open({.location = file});
  ASSERT_FALSE(opened.ok());
  EXPECT_THAT(opened.error().message, HasSubstr("another program"));
  EXPECT_TRUE(before == bytes());
}

TEST(SqliteDatabase, FindsDamageInTheMiddleOfAFile) {
  tests::TempFolder folder;
  const std::string file = folder.File("damaged.db");
  {
    auto database = Database::Open({.location = file}).value();
    for (int i = 0; i < 50; ++i) ASSERT_TRUE(PutBytes(*database, i, 3000).ok());
  }
  {
    std::fstream raw(file, std::ios::in | std::ios::out | std::ios::binary);
    const std::string garbage(4096 * 12, '\x5a');
    raw.seekp(4096 * 10);
    raw.write(garbage.data(), static_cast<std::streamsize>(garbage.size()));
  }
  auto database = Database::Open({.location = file});
  if (!database.ok()) {
    EXPECT_THAT(database.error().message, HasSubstr("damaged"));
    return;
  }
  const Status status = database.value()->Check();
  ASSERT_FALSE(status.ok());
  EXPECT_THAT(status.error().message, HasSubstr("damaged"));
}

TEST(SqliteDatabase, SaysThatTheFolderDoesNotExist) {
  const auto opened = Database::Open({.location = "/nonexistent/folder/lab.db"});
  ASSERT_FALSE(opened.ok());
  EXPECT_THAT(opened.error().message, HasSubstr("cannot be opened"));
}

TEST(SqliteDatabase, CopiesItselfWhileOthersWrite) {
  tests::TempFolder folder;
  auto database = Database::Open({.location = folder.File("a.db")}).value();
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(PutBytes(*database, i, 1000).ok());
  ASSERT_TRUE(database->BackupTo(folder.File("b.db")).ok());
  ASSERT_TRUE(PutBytes(*database, 99, 1000).ok());
  auto copy = Database::Open({.location = folder.File("b.db")}).value();
  EXPECT_EQ(CountBlobs(*copy), 20);
  EXPECT_TRUE(copy->Check().ok());
  EXPECT_FALSE(database->BackupTo(folder.File("b.db")).ok()) << "never overwrites";
}

TEST(PostgresDatabase, ConnectionsThatTheServerDroppedWhileTheyWereIdleCostNobodyAnAnswer) {
  tests::TestDatabase database(Engine::kPostgresql);
  std::vector<std::thread> together;  // so that the pool contains more than one
  for (int i = 0; i < 4; ++i) {
    together.emplace_back([&, i] { EXPECT_TRUE(PutBytes(*database, i, 10).ok()); });
  }
  for (std::thread& thread : together) thread.join();
  tests::PostgresCluster::Instance().KillConnections();
  for (int i = 4; i < 8; ++i) EXPECT_TRUE(PutBytes(*database, i, 10).ok());
  EXPECT_EQ(CountBlobs(*database), 8);
}

TEST(PostgresDatabase, ATransactionThatLosesItsConnectionIsNotTriedTwice) {
  tests::TestDatabase database(Engine::kPostgresql);
  int bodies = 0;
  const Status lost = database->Write(Durability::kPromise, [&](Transaction& tx) -> Status {
    ++bodies;
    tests::PostgresCluster::Instance().KillConnections();
    blob_store::Put(tx, "bytes", 1, Bytes(3));
    return Done{};
  });
  ASSERT_FALSE(lost.ok());
  EXPECT_EQ(lost.error().code, ErrorCode::kUnavailable);
  EXPECT_EQ(bodies, 1);
  EXPECT_TRUE(PutBytes(*database, 2, 10).ok());
  EXPECT_EQ(CountBlobs(*database), 1);
}

TEST(PostgresDatabase, RefusesToWriteInARead) {
  tests::TestDatabase database(Engine::kPostgresql);
  const Status status = database->Read([](Transaction& tx) -> Status {
    blob_store::Put(tx, "bytes", 1, Bytes(3));
    return Done{};
  });
  EXPECT_FALSE(status.ok());
  EXPECT_EQ(CountBlobs(*database), 0);
}

TEST(PostgresDatabase, OpensByEveryFormOfItsLocation) {
  const std::string keywords = tests::PostgresCluster::Instance().CreateDatabase();
  const std::size_t host = keywords.find("host=") + 5;
  std::string folder = keywords.substr(host, keywords.find(' ', host) - host);
  for (std::size_t at = 0; (at = folder.find('/', at)) != std::string::npos; at += 3) {
    folder.replace(at, 1, "%2F");
  }
  const std::string uri =
      "postgresql://postgres@" + folder + "/" + keywords.substr(keywords.rfind('=') + 1);
  for (const std::string& location : {uri, uri + "?connect_timeout=5", keywords}) {
    const auto opened = Database::Open({.location = location});
    EXPECT_TRUE(opened.ok()) << location << ": " << opened.error().message;
  }
}

TEST(PostgresDatabase, RefusesALocationThatCannotBeParsedAndShowsNoPassword) {
  for (const char* location : {"postgresql://[::1/x",
                               "postgresql:hots=x",
                               "postgresql:dbname='x",
                               "postgresql://me:S3cret%zz@h/x",
                               "postgresql://me:pw/S3cret@h/x",
                               "postgresql:password S3cret",
                               "PostgreSQL://me:S3cret@h/x",
                               "mysql://me:S3cret@h/x"}) {
    const auto opened = Database::Open({.location = location});
    ASSERT_FALSE(opened.ok()) << location;
    EXPECT_EQ(opened.error().code, ErrorCode::kInvalid) << opened.error().message;
    EXPECT_EQ(opened.error().message.find("S3cret"), std::string::npos) << opened.error().message;
  }
}

TEST(PostgresLocation, KeepsSpacesQuotesAndEscapesOfValues) {
  EXPECT_EQ(PostgresParameters("postgresql://faultlab@/faultlab").value(),
            "user='faultlab' dbname='faultlab' fallback_application_name=faultlab");
  EXPECT_EQ(PostgresParameters("postgresql://u:a%20b%27%5C@/my%20lab").value(),
            R"(user='u' password='a b\'\\' dbname='my lab' fallback_application_name=faultlab)");
}

TEST(PostgresDatabase, SaysThatThereIsNoServer) {
  const auto opened = Database::Open({.location = "postgresql:host=/nonexistent dbname=x"});
  ASSERT_FALSE(opened.ok());
  EXPECT_EQ(opened.error().code, ErrorCode::kUnavailable);
}

}  // namespace
}  // namespace faultlab::server

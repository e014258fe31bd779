#include "server/storage/migrations.h"

#include <gmock/gmock.h>
#include <soci/postgresql/soci-postgresql.h>
#include <soci/soci.h>
#include <soci/sqlite3/soci-sqlite3.h>

#include <algorithm>
#include <regex>
#include <set>

#include "tests/support/engines.h"
#include "tests/support/postgres_cluster.h"
#include "tests/support/temp_folder.h"

namespace faultlab::server {
namespace {

class Migrations : public testing::TestWithParam<Engine> {
 protected:
  std::string NewLocation() {
    if (GetParam() == Engine::kSqlite) return folder_.File("m" + std::to_string(++count_) + ".db");
    return tests::PostgresCluster::Instance().CreateDatabase();
  }
  soci::session Raw(const std::string& location) const {
    if (GetParam() == Engine::kSqlite) return {*soci::factory_sqlite3(), location};
    return {*soci::factory_postgresql(), location.substr(std::string("postgresql:").size())};
  }
  /// Every column of every table, as reported by the engine.
  std::set<std::string> Shape(const std::string& location) const {
    const char* query =
        GetParam() == Engine::kSqlite
            ? "SELECT type || ' ' || name || ' ' || COALESCE(sql, '') FROM sqlite_master"
            : "SELECT table_name || '.' || column_name || ' ' || data_type || ' ' || is_nullable "
              "FROM information_schema.columns WHERE table_schema = 'public' UNION ALL "
              "SELECT indexdef FROM pg_indexes WHERE schemaname = 'public' UNION ALL "
              "SELECT conname || ' ' || pg_get_constraintdef(oid) FROM pg_constraint "
              "WHERE connamespace = 'public'::regnamespace";
    soci::session session = Raw(location);
    const soci::rowset<std::string> rows = (session.prepare << query);
    return {rows.begin(), rows.end()};
  }
  tests::TempFolder folder_;
  int count_ = 0;
};

TEST_P(Migrations, AreNumberedWithoutHoles) {
  int expected = AllMigrations().front().version;
  for (const auto& step : AllMigrations()) EXPECT_EQ(step.version, expected++);
}

TEST_P(Migrations, MakeEveryTableAndIndexOfTheSchema) {
  const std::string location = NewLocation();
  ASSERT_TRUE(Database::Open({.location = location}).ok());
  const auto made = Shape(location);
  int objects = 0;
  for (const Statement& each : AllMigrations().front().statements) {
    if (each.engine.value_or(GetParam()) != GetParam()) continue;
    std::smatch name;
    if (!std::regex_search(
            each.text, name, std::regex("^CREATE (?:UNIQUE )?(?:TABLE|INDEX) (\\w+)"))) {
      continue;
    }
    ++objects;
    EXPECT_TRUE(std::ranges::any_of(made, [&](const std::string& line) {
      return line.find(name[1].str()) != std::string::npos;
    })) << name[1];
  }
  EXPECT_GT(objects, 70);
}

TEST_P(Migrations, DoNothingTheSecondTime) {
  const std::string location = NewLocation();
  ASSERT_TRUE(Database::Open({.location = location}).ok());
  const auto before = Shape(location);
  ASSERT_TRUE(Database::Open({.location = location}).ok());
  EXPECT_EQ(Shape(location), before);
}

TEST_P(Migrations, RefuseASchemaFromTheFuture) {
  const std::string location = NewLocation();
  ASSERT_TRUE(Database::Open({.location = location}).ok());
  {
    soci::session session = Raw(location);
    session << "INSERT INTO schema_version (version, description) VALUES (9999, 'future')";
  }
  const auto opened = Database::Open({.location = location});
  ASSERT_FALSE(opened.ok());
  EXPECT_THAT(opened.error().message, testing::HasSubstr("newer faultlab"));
}

TEST_P(Migrations, RefuseTheVersionsOfAnotherProgramAndOfOldOnesAndChangeNothing) {
  for (const char* row : {"1, 'of a shop'", "1, 'recordings: record, chunks, events'"}) {
    const std::string location = NewLocation();
    {
      soci::session session = Raw(location);
      session << "CREATE TABLE schema_version (version INTEGER, description TEXT)";
      session << "INSERT INTO schema_version (version, description) VALUES (" + std::string(row) +
                     ")";
    }
    const auto before = Shape(location);
    const auto opened = Database::Open({.location = location});
    ASSERT_FALSE(opened.ok());
    EXPECT_EQ(opened.error().code, core::ErrorCode::kInvalid);
    EXPECT_THAT(opened.error().message,
                testing::HasSubstr("another program, or of faultlab before 1.0.0"));
    EXPECT_EQ(Shape(location), before);
  }
}

TEST_P(Migrations, RefuseAnEmptyDatabaseWhereOneMustBe) {
  const std::string location = NewLocation();
  EXPECT_FALSE(Database::Open({.location = location, .existing = true}).ok());
  ASSERT_TRUE(Database::Open({.location = location}).ok());
  EXPECT_TRUE(Database::Open({.location = location, .existing = true}).ok());
}

INSTANTIATE_TEST_SUITE_P(Engines, Migrations, tests::kBothEngines, tests::EngineName);

}  // namespace
}  // namespace faultlab::server

#include "server/storage/migrations.h"

#include <gmock/gmock.h>
#include <soci/postgresql/soci-postgresql.h>
#include <soci/soci.h>
#include <soci/sqlite3/soci-sqlite3.h>

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
  int expected = 1;
  for (const auto& step : AllMigrations()) EXPECT_EQ(step.version, expected++);
}

TEST_P(Migrations, LeadFromEveryEarlierSchemaToTheSameNewestOneAndKeepItsRows) {
  const int newest = AllMigrations().back().version;
  const std::string fresh = NewLocation();
  ASSERT_TRUE(Database::Open({.location = fresh}).ok());
  const auto wanted = Shape(fresh);
  ASSERT_GT(wanted.size(), 5u);
  for (int from = 1; from < newest; ++from) {
    const std::string location = NewLocation();
    {
      soci::session session = Raw(location);
      ASSERT_EQ(Migrate(session, GetParam(), from).value(), from);
      session << "INSERT INTO recording (id, name, owner, rig, source, server_id, epoch, period_s, "
                 "plan_json, state, created_ms, samples, next_index, diagnosis_json, verdict) "
                 "VALUES ('run-old', 'old', 'guest', 'sim-1', 'run', 's', 3, 0.01, '{}', "
                 "'finished', 1, 0, 0, '', '')";
    }
    auto database = Database::Open({.location = location});
    ASSERT_TRUE(database.ok()) << "from " << from << ": " << database.error().message;
    EXPECT_EQ(database.value()->schema_version(), newest);
    EXPECT_EQ(Shape(location), wanted) << "from " << from;
    soci::session session = Raw(location);
    std::string name;
    session << "SELECT name FROM recording WHERE id = 'run-old'", soci::into(name);
    EXPECT_EQ(name, "old");
  }
}

TEST_P(Migrations, TakeWhatListsShowOutOfTheBodiesOfJobsAndTheBodiesOfThoseThatEnded) {
  const std::string location = NewLocation();
  {
    soci::session session = Raw(location);
    ASSERT_EQ(Migrate(session, GetParam(), 12).value(), 12);
    const auto job = [&](const std::string& id, const std::string& state, const std::string& body) {
      session
          << "INSERT INTO job (id, owner, account_id, batch, name, body, state, run_id, error, "
             "created_ms, started_ms, ended_ms, server_id, lease_until_ms, attempts, result) "
             "VALUES (:id, 'user:1', 1, 'b', '', :body, :state, '', '', 1, 0, 0, '', 0, 0, 'r')",
          soci::use(id, "id"), soci::use(body, "body"), soci::use(state, "state");
    };
    job("a", "waiting", R"({"name":"šest","rig":"bench-1"})");
    job("b", "finished", R"({"name":"x","diagnose":{"recording":"run-1"}})");
    job("c", "waiting", R"({"name":"a\u0000b"})");
    job("d", "failed", "");
  }
  ASSERT_TRUE(Database::Open({.location = location}).ok());
  soci::session session = Raw(location);
  std::vector<std::string> found;
  const soci::rowset<std::string> rows =
      (session.prepare << "SELECT id || ':' || run_name || ':' || rig || ':' || recording || ':' "
                          "|| CAST(body_bytes AS TEXT) || ':' || CAST(LENGTH(body) AS TEXT) || "
                          "':' || result FROM job WHERE id <> 'c' ORDER BY id");
  for (const std::string& row : rows) found.push_back(row);
  EXPECT_THAT(found,
              testing::ElementsAre("a:šest:bench-1::32:31:r", "b:x::run-1:0:0:r", "d::::0:0:r"));
}

TEST_P(Migrations, ForgetNamesOnTheBusThatWereNeverRigs) {
  const std::string location = NewLocation();
  {
    soci::session session = Raw(location);
    ASSERT_TRUE(Migrate(session, GetParam(), 9).ok());
    for (const char* row : {"'invented-1', 'forged', 0, ''",
                            "'planned', 'bench', 0, ''",
                            "'used', 'bench', 3, ''",
                            "'new-here', 'bench', 0, 'local'"}) {
      session << "INSERT INTO lab_rig (id, rig_class, epoch, server, elastic, status, "
                 "cleaning_due_ms, wear_ms, reason) VALUES (" +
                     std::string(row) + ", 0, 0, 0, 0, '')";
    }
    session << "INSERT INTO lab_outage (id, rig, start_ms, end_ms, reason) "
               "VALUES (1, 'planned', 1, 2, '')";
  }
  ASSERT_TRUE(Database::Open({.location = location}).ok());
  soci::session session = Raw(location);
  const soci::rowset<std::string> rows = (session.prepare << "SELECT id FROM lab_rig ORDER BY id");
  EXPECT_EQ(std::vector<std::string>(rows.begin(), rows.end()),
            (std::vector<std::string>{"new-here", "planned", "used"}));
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

TEST_P(Migrations, RefuseTheVersionsOfAnotherProgramAndChangeNothing) {
  const std::string location = NewLocation();
  {
    soci::session session = Raw(location);
    session << "CREATE TABLE schema_version (version INTEGER, description TEXT)";
    session << "INSERT INTO schema_version (version, description) VALUES (1, 'of a shop')";
  }
  const auto before = Shape(location);
  const auto opened = Database::Open({.location = location});
  ASSERT_FALSE(opened.ok());
  EXPECT_EQ(opened.error().code, core::ErrorCode::kInvalid);
  EXPECT_THAT(opened.error().message, testing::HasSubstr("another program"));
  EXPECT_EQ(Shape(location), before);
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

#include <gtest/gtest.h>

#include <soci/soci.h>
#include <soci/sqlite3/soci-sqlite3.h>

#include <algorithm>
#include <string>
#include <vector>

#include "server/auth/audit_verbs.h"
#include "server/storage/database.h"
#include "server/storage/recording_store.h"
#include "tests/server/cli/child_program.h"

namespace faultlab::server {
namespace {

bool Contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// A database as the server leaves it.
class CliAdminOfALab : public ChildProgram {
 protected:
  CliAdminOfALab() {
    Write("data/made", "");
    EXPECT_TRUE(Database::Open({.location = File("data/faultlab.db")}).ok());
  }
  Finished Admin(const std::string& arguments) const { return Run("admin " + arguments); }
};

TEST_F(CliAdminOfALab, MakesAnAccountWithALinkAndAKeyThatAreShownOnce) {
  const Finished added = Admin("users add ana --name Ана --role instructor");
  ASSERT_EQ(added.exit_code, 0) << added.err;
  EXPECT_TRUE(Contains(added.out, "fll_")) << added.out;
  const Finished key = Admin("keys add ana --scope runs:read --days 30");
  ASSERT_EQ(key.exit_code, 0) << key.err;
  EXPECT_TRUE(Contains(key.out, "flk_")) << key.out;
  const std::string users = Admin("users list").out;
  EXPECT_TRUE(Contains(users, "ana\tinstructor\tno password yet\tАна")) << users;
  const std::string keys = Admin("keys list ana").out;
  EXPECT_TRUE(Contains(keys, "good")) << keys;
  EXPECT_FALSE(Contains(users + keys, "fl")) << "secrets are shown once";
  EXPECT_EQ(Admin("keys revoke ana 1").exit_code, 0);
  EXPECT_TRUE(Contains(Admin("keys list ana").out, "revoked"));
  EXPECT_EQ(Admin("users disable ana").exit_code, 0);
  EXPECT_TRUE(Contains(Admin("users list").out, "disabled"));
}

TEST_F(CliAdminOfALab, ExportsAndErasesAPerson) {
  ASSERT_EQ(Admin("users add zelda --name \"Zelda Unique\"").exit_code, 0);
  ASSERT_EQ(Admin("users add zelda.two").exit_code, 0);
  ASSERT_EQ(Admin("keys add zelda").exit_code, 0);
  {
    const auto database = Database::Open({.location = File("data/faultlab.db")});
    RecordingStore store(*database.value());
    RunRecord record;
    record.id = "rec-1";
    record.owner = "user:1";
    record.source = "run";
    ASSERT_TRUE(store.Begin(record).ok());
    core::Sample sample;
    sample.um_v = 1.25;
    ASSERT_TRUE(store.AppendChunk("rec-1", 0, {&sample, 1}).ok());
    EXPECT_EQ(Admin("users erase zelda --yes").exit_code, 2) << "it runs";
    ASSERT_TRUE(store.Finish("rec-1", RunState::kFinished, WallTime{}, "{}", "nominal").ok());
  }
  const Finished exported = Admin("users export zelda kept");
  ASSERT_EQ(exported.exit_code, 0) << exported.err;
  const std::string person = Read("kept/person.json");
  EXPECT_TRUE(Contains(person, "Zelda Unique") && Contains(person, "rec-1")) << person;
  EXPECT_FALSE(Contains(person, "hash"));
  EXPECT_TRUE(Contains(Read("kept/rec-1.csv"), "1.25"));
  EXPECT_EQ(Admin("users export zelda kept").exit_code, 2) << "a new folder";

  EXPECT_EQ(Admin("users erase zelda").exit_code, 2) << "it must be said twice";
  const Finished erased = Admin("users erase zelda --yes");
  ASSERT_EQ(erased.exit_code, 0) << erased.err;
  const std::string users = Admin("users list").out;
  EXPECT_TRUE(Contains(users, "erased-1\tstudent\tdisabled")) << users;
  EXPECT_TRUE(Contains(users, "zelda.two")) << "another person";
  const auto database = Database::Open({.location = File("data/faultlab.db")});
  const auto left = database.value()->Read([](Transaction& tx) -> core::Result<std::int64_t> {
    std::int64_t lines = 0;
    tx.sql() << "SELECT (SELECT COUNT(*) FROM recording) + (SELECT COUNT(*) FROM blob_store WHERE "
                "owner LIKE 'recording%') + (SELECT COUNT(*) FROM api_key) + (SELECT COUNT(*) FROM "
                "audit_log WHERE object = 'zelda' OR detail LIKE '%Zelda U%' OR detail = 'zelda')",
        soci::into(lines);
    return lines;
  });
  EXPECT_EQ(left.value(), 0);
  const core::Status changed =
      database.value()->Write(Durability::kPromise, [](Transaction& tx) -> core::Status {
        tx.sql() << "UPDATE audit_log SET actor = 'nobody'";
        return core::Done{};
      });
  EXPECT_FALSE(changed.ok()) << "the log is locked again";
}

TEST_F(CliAdminOfALab, RefusesWhatCannotBeByName) {
  EXPECT_EQ(Admin("users add ana").exit_code, 0);
  EXPECT_EQ(Admin("users add ana").exit_code, 2) << "taken";
  EXPECT_EQ(Admin("users add \"A b\"").exit_code, 2);
  EXPECT_EQ(Admin("users add bob --role king").exit_code, 2);
  EXPECT_EQ(Admin("users disable nobody").exit_code, 2);
  EXPECT_EQ(Admin("keys add ana --scope everything").exit_code, 2);
  EXPECT_EQ(Admin("keys add ana --scope runs:read --days 4000").exit_code, 2);
  const Finished none = Admin("users list --data nowhere");
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_TRUE(Contains(none.err, "there is no database at nowhere/faultlab.db")) << none.err;
  EXPECT_FALSE(Exists("nowhere"));
}

TEST_F(CliAdminOfALab, NotesWhatItHasDoneByTheVerbsOfTheServer) {
  for (const char* command : {"add", "disable", "enable", "link"}) {
    ASSERT_EQ(Admin(std::string("users ") + command + " ana").exit_code, 0) << command;
  }
  using Lines = std::vector<std::string>;
  const auto database = Database::Open({.location = File("data/faultlab.db")});
  const auto log = database.value()->Read([](Transaction& tx) -> core::Result<Lines> {
    const soci::rowset<soci::row> rows =
        (tx.sql().prepare << "SELECT verb, detail FROM audit_log ORDER BY seq");
    Lines lines;
    for (const soci::row& row : rows) {
      const auto verb = row.get<std::string>(0);
      EXPECT_NE(std::ranges::find(kAuditVerbs, verb), kAuditVerbs.end()) << verb;
      lines.push_back(verb + " " + row.get<std::string>(1));
    }
    return lines;
  });
  EXPECT_EQ(log.value(),
            (Lines{"create_user ",
                   "change_user disabled",
                   "change_user enabled",
                   "reset_link faultlab admin"}));
}

TEST_F(CliAdminOfALab, SaysWhenWhatItHasDoneIsNotInTheAuditLog) {
  ASSERT_EQ(Admin("users add ana").exit_code, 0);
  const auto dropped = std::move(Database::Open({.location = File("data/faultlab.db")}))
                           .value()
                           ->Write(Durability::kPromise, [](Transaction& tx) -> core::Status {
                             tx.sql() << "DROP TABLE audit_log";
                             return core::Done{};
                           });
  ASSERT_TRUE(dropped.ok()) << dropped.error().message;
  const Finished done = Admin("users disable ana");
  EXPECT_EQ(done.exit_code, 0) << "it is done";
  EXPECT_TRUE(Contains(done.err, "not in the audit log")) << done.err;
}

TEST_F(CliAdminOfALab, BringsABackupBackIntoAnEmptyFolderAndNeverReplacesAFile) {
  ASSERT_EQ(Admin("users add ana --name Ана").exit_code, 0);
  const Finished saved = Admin("backup lab.db");
  ASSERT_EQ(saved.exit_code, 0) << saved.err;
  const std::string copy = Read("lab.db");
  EXPECT_EQ(Admin("backup lab.db").exit_code, 2);
  EXPECT_EQ(Read("lab.db"), copy);
  EXPECT_EQ(Admin("restore lab.db").exit_code, 2) << "there is a database already";
  Write("new/made", "");
  EXPECT_EQ(Admin("restore lab.db --data new").exit_code, 0);
  EXPECT_TRUE(Contains(Admin("users list --data new").out, "Ана"));
  EXPECT_EQ(Admin("check --data new").exit_code, 0);
}

TEST_F(CliAdminOfALab, FindsADamagedDatabase) {
  ASSERT_EQ(Admin("users add ana").exit_code, 0);
  ASSERT_EQ(Admin("backup lab.db").exit_code, 0);
  std::string bytes = Read("lab.db");
  ASSERT_GT(bytes.size(), 40'000u);
  for (std::size_t i = 9000; i < 30'000; ++i) bytes[i] = static_cast<char>(i * 7919 >> 5);
  Write("bad/faultlab.db", bytes);
  EXPECT_NE(Admin("check --data bad").exit_code, 0);
  Write("torn.db", bytes.substr(0, 5000));
  Write("empty/made", "");
  EXPECT_NE(Admin("restore torn.db --data empty").exit_code, 0);
}

TEST_F(CliAdminOfALab, RestoresNothingThatIsNotALab) {
  Write("empty.db", "");
  EXPECT_EQ(Admin("restore empty.db --data new").exit_code, 2);
  EXPECT_FALSE(Exists("new/faultlab.db"));
  soci::session(soci::sqlite3, "dbname=" + File("shop.db")) << "CREATE TABLE goods (id INTEGER)";
  const Finished foreign = Admin("restore shop.db --data new");
  EXPECT_EQ(foreign.exit_code, 2);
  EXPECT_TRUE(Contains(foreign.err, "another program")) << foreign.err;
  EXPECT_FALSE(Exists("new/faultlab.db"));
  EXPECT_FALSE(Exists("new/faultlab.db.part"));
}

TEST_F(CliAdminOfALab, FindsADamagedSampleAndTheServerRefusesItUntilItIsCutOut) {
  {
    auto database = Database::Open({.location = File("data/faultlab.db")}).value();
    RecordingStore store(*database);
    RunRecord record;
    record.id = "run-a";
    record.source = "run";
    ASSERT_TRUE(store.Begin(record).ok());
    std::vector<core::Sample> samples(100);
    for (std::size_t i = 0; i < samples.size(); ++i) samples[i].index = static_cast<int>(i);
    ASSERT_TRUE(store.AppendChunk("run-a", 0, samples).ok());
    ASSERT_TRUE(store.Finish("run-a", RunState::kFinished, WallTime{}, "{}", "").ok());
    EXPECT_EQ(Admin("check").exit_code, 0);
    const core::Status damaged =
        database->Write(Durability::kPromise, [](Transaction& tx) -> core::Status {
          tx.sql() << "UPDATE blob_store SET bytes = CAST(substr(bytes, 1, 40) || x'5a' || "
                      "substr(bytes, 42) AS BLOB)";
          return core::Done{};
        });
    ASSERT_TRUE(damaged.ok());
  }
  const Finished found = Admin("check");
  EXPECT_EQ(found.exit_code, 1);
  EXPECT_TRUE(Contains(found.err, "run-a")) << found.err;
  ASSERT_EQ(Admin("backup bad.db").exit_code, 0);
  EXPECT_EQ(Admin("restore bad.db --data new").exit_code, 2);
  const Finished served = Run("serve --data data --listen 127.0.0.1:0", "timeout 60");
  EXPECT_EQ(served.exit_code, 1) << served.out;
  EXPECT_TRUE(Contains(served.err, "run-a")) << served.err;
  const Finished cut = Admin("check --cut-damage");
  EXPECT_EQ(cut.exit_code, 0) << cut.err;
  EXPECT_TRUE(Contains(cut.out, "run-a: 100 samples taken out")) << cut.out;
  EXPECT_EQ(Admin("check").exit_code, 0);
}

TEST_F(CliAdminOfALab, ShowsWhatRetentionWouldDeleteAndDeletesNothing) {
  const Finished dry = Admin("retention --dry-run");
  ASSERT_EQ(dry.exit_code, 0) << dry.err;
  EXPECT_TRUE(Contains(dry.out, "would delete 0 recordings")) << dry.out;
}

}  // namespace
}  // namespace faultlab::server

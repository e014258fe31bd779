#include "server/storage/recording_store.h"

#include <gmock/gmock.h>
#include <soci/soci.h>

#include <algorithm>

#include "core/types/check.h"
#include "tests/support/engines.h"
#include "tests/support/test_database.h"

namespace faultlab::server {
namespace {

using core::ErrorCode;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr WallTime kStart{std::chrono::milliseconds{1'770'000'000'000}};

class RecordingStoreTest : public testing::TestWithParam<Engine> {
 protected:
  RunRecord Record(const std::string& id, int age_s = 0) {
    RunRecord record;
    record.id = id;
    record.name = "Prüfung Ω 日本 مختبر";
    record.owner = "user:7";
    record.rig = "sim-1";
    record.source = "run";
    record.server_id = "server-a";
    record.epoch = 42;
    record.period_s = 0.1 + 0.2;  // not a round number: must be read back bit for bit
    record.plan_json = R"({"name":"a \"quoted\" 'one'"})";
    record.created_at = kStart - std::chrono::seconds(age_s);
    return record;
  }
  std::vector<core::Sample> Samples(std::int64_t first, int count) {
    std::vector<core::Sample> samples;
    for (int i = 0; i < count; ++i) {
      core::Sample s;
      s.index = first + i;
      s.t_s = static_cast<double>(s.index) * 0.01;
      s.uc_v = 2.0 + static_cast<double>(s.index % 2);
      s.um_v = 1.0 / static_cast<double>(s.index + 3);
      samples.push_back(s);
    }
    return samples;
  }
  tests::TestDatabase database_{GetParam()};
  RecordingStore store_{*database_};
};

TEST_P(RecordingStoreTest, GivesBackARecordAsItWasBegun) {
  const RunRecord record = Record("run-1");
  ASSERT_TRUE(store_.Begin(record).ok());
  const RunRecord got = store_.Get("run-1").value();
  EXPECT_EQ(got.name, record.name);
  EXPECT_EQ(got.owner, record.owner);
  EXPECT_EQ(got.rig, record.rig);
  EXPECT_EQ(got.epoch, 42u);
  EXPECT_EQ(got.period_s, record.period_s);
  EXPECT_EQ(got.plan_json, record.plan_json);
  EXPECT_EQ(got.state, RunState::kRunning);
  EXPECT_EQ(got.created_at, record.created_at);
  EXPECT_EQ(got.ended_at, std::nullopt);
  EXPECT_EQ(got.samples, 0);
}

TEST_P(RecordingStoreTest, GivesBackSamplesAcrossChunkBorders) {
  ASSERT_TRUE(store_.Begin(Record("run-1")).ok());
  for (std::int64_t first = 0; first < 500; first += 100) {
    ASSERT_TRUE(store_.AppendChunk("run-1", first, Samples(first, 100)).ok());
  }
  const auto all = store_.LoadSamples("run-1", 0, 1000).value();
  ASSERT_EQ(all.size(), 500u);
  EXPECT_EQ(all[321].um_v, Samples(321, 1)[0].um_v);
  const auto some = store_.LoadSamples("run-1", 150, 250).value();
  ASSERT_EQ(some.size(), 100u);
  EXPECT_EQ(some.front().index, 150);
  EXPECT_EQ(some.back().index, 249);
  EXPECT_EQ(store_.Get("run-1").value().samples, 500);
}

TEST_P(RecordingStoreTest, AcceptsAGapAndRefusesAnOverlap) {
  ASSERT_TRUE(store_.Begin(Record("run-1")).ok());
  ASSERT_TRUE(store_.AppendChunk("run-1", 0, Samples(0, 100)).ok());
  ASSERT_TRUE(store_.AppendChunk("run-1", 130, Samples(130, 10)).ok());
  const auto overlap = store_.AppendChunk("run-1", 139, Samples(139, 10));
  ASSERT_FALSE(overlap.ok());
  EXPECT_EQ(overlap.error().code, ErrorCode::kConflict);
  EXPECT_EQ(store_.LoadSamples("run-1", 0, 1000).value().size(), 110u);
}

TEST_P(RecordingStoreTest, TakesSamplesOutOfOrderForABug) {
  ASSERT_TRUE(store_.Begin(Record("run-1")).ok());
  auto samples = Samples(0, 3);
  std::swap(samples[1], samples[2]);
  EXPECT_THROW((void)store_.AppendChunk("run-1", 0, samples), core::ContractError);
}

TEST_P(RecordingStoreTest, KeepsEventsInTheOrderInWhichTheyCame) {
  ASSERT_TRUE(store_.Begin(Record("run-1")).ok());
  const std::vector<RecordedEvent> first = {{10, "started", "{}"}};
  ASSERT_TRUE(store_.AppendEvents("run-1", first).ok());
  const std::vector<RecordedEvent> two = {{9, "late", R"({"a":1})"}, {12, "detected", "{}"}};
  ASSERT_TRUE(store_.AppendEvents("run-1", two).ok());
  const auto events = store_.LoadEvents("run-1").value();
  ASSERT_EQ(events.size(), 3u);
  EXPECT_EQ(events[0].kind, "started");
  EXPECT_EQ(events[1].kind, "late");
  EXPECT_EQ(events[1].index, 9);
  EXPECT_EQ(events[1].json, R"({"a":1})");
  EXPECT_EQ(events[2].kind, "detected");
}

TEST_P(RecordingStoreTest, StoresOnceWhatIsSentAgainAfterALostAnswer) {
  ASSERT_TRUE(store_.Begin(Record("run-1")).ok());
  const auto chunk = Samples(0, 100);
  ASSERT_TRUE(store_.AppendChunk("run-1", 0, chunk).ok());
  EXPECT_TRUE(store_.AppendChunk("run-1", 0, chunk).ok());
  auto other = chunk;
  other.back().um_v += 1.0;
  EXPECT_EQ(store_.AppendChunk("run-1", 0, other).error().code, ErrorCode::kConflict);
  EXPECT_EQ(store_.Get("run-1").value().samples, 100);

  const std::vector<RecordedEvent> two = {{9, "a", "{}"}, {12, "b", "{}"}};
  const std::vector<RecordedEvent> three = {{13, "c", "{}"}};
  ASSERT_TRUE(store_.AppendEvents("run-1", two, 0).ok());
  EXPECT_TRUE(store_.AppendEvents("run-1", two, 0).ok());
  ASSERT_TRUE(store_.AppendEvents("run-1", three, 2).ok());
  EXPECT_TRUE(store_.AppendEvents("run-1", three, 2).ok());
  EXPECT_EQ(store_.LoadEvents("run-1").value().size(), 3u);
}

TEST_P(RecordingStoreTest, ARunWhoseFaultWasSetBackIsFoundByItsFault) {
  const auto ended = [&](const std::string& id, const char* diagnosis, const char* verdict) {
    ASSERT_TRUE(store_.Begin(Record(id)).ok());
    ASSERT_TRUE(store_.Finish(id, RunState::kFinished, kStart, diagnosis, verdict).ok());
  };
  ended("run-1", R"({"verdict":"nominal","episodes":[]})", "nominal");
  ended("run-2", R"({"verdict":"nominal","episodes":[{"verdict":"fault"}]})", "nominal");
  ended("run-3", R"({"verdict":"fault","episodes":[{"verdict":"fault"}]})", "fault");
  const auto found = [&](const char* verdict) {
    RunFilter filter;
    filter.verdict = verdict;
    std::vector<std::string> ids;
    const RunPage page = store_.List("", 10, filter).value();
    for (const RunRecord& each : page.items) ids.push_back(each.id);
    std::ranges::sort(ids);
    return ids;
  };
  EXPECT_THAT(found("fault"), ElementsAre("run-2", "run-3"));
  EXPECT_THAT(found("nominal"), ElementsAre("run-1"));
}

TEST_P(RecordingStoreTest, FinishesOnceAndTakesNoSamplesAfterwards) {
  ASSERT_TRUE(store_.Begin(Record("run-1")).ok());
  const WallTime end = kStart + std::chrono::seconds(20);
  ASSERT_TRUE(
      store_.Finish("run-1", RunState::kFinished, end, R"({"verdict":"fault"})", "fault").ok());
  const RunRecord got = store_.Get("run-1").value();
  EXPECT_EQ(got.state, RunState::kFinished);
  EXPECT_EQ(got.ended_at, end);
  EXPECT_EQ(got.verdict, "fault");
  EXPECT_EQ(got.diagnosis_json, R"({"verdict":"fault"})");
  EXPECT_EQ(store_.Finish("run-1", RunState::kFailed, end, "", "").error().code,
            ErrorCode::kConflict);
  EXPECT_EQ(store_.AppendChunk("run-1", 0, Samples(0, 5)).error().code, ErrorCode::kConflict);
  ASSERT_TRUE(store_.ReplaceDiagnosis("run-1", "{}", "nominal").ok());
  EXPECT_EQ(store_.Get("run-1").value().verdict, "nominal");
}

TEST_P(RecordingStoreTest, PagesNewestFirstWithoutLosingOrRepeatingOne) {
  for (int i = 0; i < 7; ++i) {
    // Pairs have the same creation time; then the id decides.
    ASSERT_TRUE(store_.Begin(Record("run-" + std::to_string(i), i / 2)).ok());
  }
  std::vector<std::string> ids;
  std::string cursor;
  int pages = 0;
  do {
    const RunPage page = store_.List(cursor, 3, {}).value();
    for (const auto& record : page.items) ids.push_back(record.id);
    cursor = page.next_cursor;
    ++pages;
  } while (!cursor.empty());
  EXPECT_EQ(pages, 3);
  EXPECT_THAT(ids, ElementsAre("run-1", "run-0", "run-3", "run-2", "run-5", "run-4", "run-6"));
}

TEST_P(RecordingStoreTest, ASearchForAComponentDoesNotFindTheLongerNameOfAnother) {
  const auto named = [&](const char* id, const char* name, const char* note) {
    RunRecord record = Record(id);
    record.name = name;
    ASSERT_TRUE(store_.Begin(record).ok());
    ASSERT_TRUE(store_.Describe(id, std::nullopt, note).ok());
  };
  named("run-a", "Broken R1", "");
  named("run-b", "R12 is broken", "");
  named("run-c", "", "first R10, then r1");
  named("run-d", "100 times R123", "");
  const auto found = [&](const char* text) {
    std::vector<std::string> ids;
    RunFilter filter;
    filter.text = text;
    const RunPage page = store_.List("", 10, filter).value();
    for (const RunRecord& each : page.items) ids.push_back(each.id);
    std::ranges::sort(ids);
    return ids;
  };
  EXPECT_THAT(found("R1"), ElementsAre("run-a", "run-c"));
  EXPECT_THAT(found("r12"), ElementsAre("run-b"));
  EXPECT_THAT(found("R"), ElementsAre("run-a", "run-b", "run-c", "run-d"));
  EXPECT_THAT(found("broken"), ElementsAre("run-a", "run-b"));
  EXPECT_THAT(found("%"), testing::IsEmpty()) << "no pattern";
}

TEST_P(RecordingStoreTest, ListsOneOwnersOnlyAndRefusesAForgedCursor) {
  RunRecord other = Record("run-other");
  other.owner = "user:8";
  ASSERT_TRUE(store_.Begin(Record("run-1")).ok());
  ASSERT_TRUE(store_.Begin(other).ok());
  const RunPage page = store_.List("", 10, {.owner = "user:8", .source = std::nullopt}).value();
  ASSERT_EQ(page.items.size(), 1u);
  EXPECT_EQ(page.items[0].id, "run-other");
  EXPECT_THAT(page.next_cursor, IsEmpty());
  for (const char* forged : {"x", "12", "12.", ".run", "99999999999999999999.a"}) {
    const auto refused = store_.List(forged, 10, {});
    ASSERT_FALSE(refused.ok()) << forged;
    EXPECT_EQ(refused.error().field, "cursor");
  }
  EXPECT_EQ(store_.List("", 0, {}).error().field, "limit");
  EXPECT_EQ(store_.List("", 501, {}).error().field, "limit");
}

TEST_P(RecordingStoreTest, FindsTheNewestRunOfAPersonOnARigInATime) {
  RunRecord old = Record("run-1", 100);
  RunRecord foreign = Record("run-2", 20);
  foreign.owner = "user:8";
  RunRecord newest = Record("run-3", 50);
  for (RunRecord* each : {&old, &foreign, &newest}) {
    each->rig = "bench-1";
    ASSERT_TRUE(store_.Begin(*each).ok());
  }
  const auto of = [&](WallTime from, WallTime to) {
    return store_.NewestOf(old.owner, "bench-1", from, to).value();
  };
  EXPECT_EQ(of(old.created_at, foreign.created_at), "run-3");
  EXPECT_EQ(of(old.created_at, old.created_at), "run-1");
  EXPECT_EQ(of(foreign.created_at, foreign.created_at), std::nullopt);
  EXPECT_EQ(store_.NewestOf(old.owner, "bench-2", old.created_at, foreign.created_at).value(),
            std::nullopt);
}

TEST_P(RecordingStoreTest, DeletesEverythingOfAnEndedRunOnly) {
  ASSERT_TRUE(store_.Begin(Record("run-1")).ok());
  ASSERT_TRUE(store_.AppendChunk("run-1", 0, Samples(0, 5)).ok());
  const std::vector<RecordedEvent> events = {{1, "started", "{}"}};
  ASSERT_TRUE(store_.AppendEvents("run-1", events).ok());
  EXPECT_EQ(store_.Delete("run-1").error().code, ErrorCode::kConflict);
  ASSERT_TRUE(store_.Finish("run-1", RunState::kStopped, kStart, "", "").ok());
  ASSERT_TRUE(store_.Delete("run-1").ok());
  EXPECT_EQ(store_.Get("run-1").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(store_.LoadSamples("run-1", 0, 10).error().code, ErrorCode::kNotFound);
  long long left = -1;
  ASSERT_TRUE(database_
                  ->Read([&](Transaction& tx) -> core::Status {
                    tx.sql() << "SELECT (SELECT COUNT(*) FROM blob_store) + "
                                "(SELECT COUNT(*) FROM recording_event)",
                        soci::into(left);
                    return core::Done{};
                  })
                  .ok());
  EXPECT_EQ(left, 0);
}

TEST_P(RecordingStoreTest, CountsAShortRecordingAsWhatItsRowsTake) {
  ASSERT_TRUE(store_.Begin(Record("run-1")).ok());
  ASSERT_TRUE(store_.AppendChunk("run-1", 0, Samples(0, 2)).ok());
  ASSERT_TRUE(store_.Begin(Record("run-2")).ok());
  ASSERT_TRUE(store_.AppendChunk("run-2", 0, Samples(0, 400)).ok());
  const std::string owner = store_.Get("run-1").value().owner;
  EXPECT_EQ(store_.SamplesOf(owner).value(), RecordingStore::kSamplesLeast + 400);
  EXPECT_EQ(store_.SamplesOf("nobody").value(), 0);
}

TEST_P(RecordingStoreTest, AnswersNotFoundForARunThatIsNotThere) {
  EXPECT_EQ(store_.Get("nope").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(store_.AppendChunk("nope", 0, Samples(0, 1)).error().code, ErrorCode::kNotFound);
  const std::vector<RecordedEvent> events = {{}};
  EXPECT_EQ(store_.AppendEvents("nope", events).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(store_.Delete("nope").error().code, ErrorCode::kNotFound);
}

TEST_P(RecordingStoreTest, RefusesAnIdThatExists) {
  ASSERT_TRUE(store_.Begin(Record("run-1")).ok());
  EXPECT_EQ(store_.Begin(Record("run-1")).error().code, ErrorCode::kConflict);
}

TEST_P(RecordingStoreTest, AfterACrashOwnRunsAreInterruptedWithTheirChunksAndOthersGoOn) {
  RunRecord of_other_server = Record("run-b");
  of_other_server.server_id = "server-b";
  ASSERT_TRUE(store_.Begin(Record("run-a")).ok());
  ASSERT_TRUE(store_.Begin(of_other_server).ok());
  ASSERT_TRUE(store_.AppendChunk("run-a", 0, Samples(0, 100)).ok());
  RunRecord upload = Record("rec-a");
  upload.source = "upload";
  ASSERT_TRUE(store_.Begin(upload).ok());
  ASSERT_TRUE(store_.AppendChunk("rec-a", 0, Samples(0, 100)).ok());
  database_.Reopen();
  RecordingStore restarted(*database_);
  const WallTime now = kStart + std::chrono::hours(1);
  const auto interrupt = [&] {
    return database_->Write(Durability::kPromise,
                            [&](Transaction& tx) -> core::Result<std::vector<std::string>> {
                              return InterruptRuns(tx, "server-a", now);
                            });
  };
  EXPECT_THAT(interrupt().value(), ElementsAre("run-a"));
  EXPECT_EQ(restarted.Get("run-a").value().state, RunState::kInterrupted);
  EXPECT_EQ(restarted.Get("run-a").value().ended_at, now);
  EXPECT_EQ(restarted.Get("run-b").value().state, RunState::kRunning);
  EXPECT_FALSE(restarted.Get("rec-a").ok()) << "half an upload is of no use to anybody";
  EXPECT_EQ(restarted.LoadSamples("run-a", 0, 1000).value().size(), 100u);
  EXPECT_THAT(interrupt().value(), IsEmpty());
}

TEST_P(RecordingStoreTest, TheRestOfAnInterruptedRunIsAddedAndItsDiagnosisMadeAgain) {
  RunRecord kept = Record("run-a");
  kept.kept_run = "12/3";
  ASSERT_TRUE(store_.Begin(kept).ok());
  ASSERT_TRUE(store_.AppendChunk("run-a", 0, Samples(0, 100)).ok());
  EXPECT_EQ(store_.AppendRecovered("run-a", Samples(100, 10)).error().code, ErrorCode::kConflict);
  const auto interrupt = [&](Transaction& tx) -> core::Status {
    InterruptRun(tx, "run-a", kStart);
    return core::Done{};
  };
  ASSERT_TRUE(database_->Write(Durability::kPromise, interrupt).ok());
  ASSERT_TRUE(store_.ReplaceDiagnosis("run-a", "{}", "nominal").ok());
  ASSERT_EQ(store_.AwaitingRecovery().value().size(), 1u);
  EXPECT_EQ(store_.AwaitingRecovery().value()[0].kept_run, "12/3");
  EXPECT_EQ(store_.Delete("run-a").error().reason, "rest_awaited");
  ASSERT_TRUE(store_.AppendRecovered("run-a", Samples(100, 10)).ok());
  ASSERT_TRUE(store_.AppendRecovered("run-a", Samples(100, 10)).ok()) << "the answer was lost";
  const std::vector<RecordedEvent> events = {{109, "finished", "{}"}};
  ASSERT_TRUE(store_.EndRecovery("run-a", RunState::kFinished, events).ok());
  const RunRecord got = store_.Get("run-a").value();
  EXPECT_EQ(got.state, RunState::kFinished);
  EXPECT_EQ(got.samples, 110);
  EXPECT_EQ(got.diagnosis_json, "");
  EXPECT_EQ(store_.LoadEvents("run-a").value().size(), 1u);
  EXPECT_THAT(store_.AwaitingRecovery().value(), IsEmpty());
  EXPECT_TRUE(store_.Delete("run-a").ok());
}

TEST_P(RecordingStoreTest, SaysThatAChunkIsDamagedInsteadOfLeavingSamplesOut) {
  ASSERT_TRUE(store_.Begin(Record("run-1")).ok());
  ASSERT_TRUE(store_.AppendChunk("run-1", 0, Samples(0, 10)).ok());
  ASSERT_TRUE(store_.AppendChunk("run-1", 10, Samples(10, 10)).ok());
  const char* damage = GetParam() == Engine::kSqlite
                           ? "UPDATE blob_store SET bytes = x'00' WHERE seq = 10"
                           : "UPDATE blob_store SET bytes = '\\x00' WHERE seq = 10";
  ASSERT_TRUE(database_
                  ->Write(Durability::kPromise,
                          [&](Transaction& tx) -> core::Status {
                            tx.sql() << damage;
                            return core::Done{};
                          })
                  .ok());
  EXPECT_TRUE(store_.LoadSamples("run-1", 0, 10).ok());
  const auto loaded = store_.LoadSamples("run-1", 0, 20);
  ASSERT_FALSE(loaded.ok());
  EXPECT_THAT(loaded.error().message, HasSubstr("damaged"));
}

INSTANTIATE_TEST_SUITE_P(Engines, RecordingStoreTest, tests::kBothEngines, tests::EngineName);

TEST(NewId, NeverRepeatsAndHoldsOnlyPlainCharacters) {
  std::set<std::string> seen;
  for (int i = 0; i < 1000; ++i) {
    const std::string id = NewId("run");
    EXPECT_EQ(id.size(), 24u);
    EXPECT_EQ(id.find_first_not_of("0123456789abcdefghijklmnopqrstuvwxyz-"), std::string::npos);
    EXPECT_TRUE(seen.insert(id).second);
  }
}

}  // namespace
}  // namespace faultlab::server

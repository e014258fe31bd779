#include "server/idempotency/idempotency_store.h"

#include <gmock/gmock.h>
#include <soci/soci.h>

#include "tests/support/engines.h"
#include "tests/support/test_database.h"

namespace faultlab::server {
namespace {

using std::chrono::milliseconds;

constexpr WallTime kNow{milliseconds{1'770'000'000'000}};

class IdempotencyStoreTest : public testing::TestWithParam<Engine> {
 protected:
  void Answer(int number, const std::string& body) {
    const std::string key = "key-" + std::to_string(number);
    ASSERT_FALSE(answers_.Begin("user:1", key, "hash", At(number)).value().has_value());
    ASSERT_TRUE(answers_.Finish("user:1", key, 400, body).ok());
  }
  /// Repeats the request: true if the earlier answer is returned; otherwise it is begun as a new
  /// one.
  bool Remembers(const std::string& key) {
    return answers_.Begin("user:1", key, "hash", At(9999)).value().has_value();
  }
  static WallTime At(int number) { return kNow + milliseconds(number); }

  tests::TestDatabase database_{GetParam()};
  IdempotencyStore answers_{*database_};
};

TEST_P(IdempotencyStoreTest, AnOwnersOldestGoBeyondAThousandAndWhatIsBeingDoneStays) {
  ASSERT_FALSE(answers_.Begin("user:1", "under way", "hash", kNow).value().has_value());
  ASSERT_FALSE(answers_.Begin("user:2", "other", "hash", kNow).value().has_value());
  ASSERT_TRUE(answers_.Finish("user:2", "other", 201, "theirs").ok());
  Answer(1, "body");
  Answer(2, "body");
  const auto filled = database_->Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    for (int i = 3; i <= IdempotencyStore::kOfOwnerMax; ++i) {
      const std::string key = "key-" + std::to_string(i);
      const std::int64_t at_ms = ToMilliseconds(At(i));
      tx.sql() << "INSERT INTO remembered_answer (owner, idempotency_key, request_hash, status, "
                  "body, at_ms) VALUES ('user:1', :key, 'hash', 400, 'body', :at)",
          soci::use(key, "key"), soci::use(at_ms, "at");
    }
    return core::Done{};
  });
  ASSERT_TRUE(filled.ok());
  Answer(IdempotencyStore::kOfOwnerMax + 1, "body");
  EXPECT_FALSE(Remembers("key-1"));
  EXPECT_TRUE(Remembers("key-2"));
  EXPECT_EQ(answers_.Begin("user:1", "under way", "hash", At(5000)).error().code,
            core::ErrorCode::kBusy);
  EXPECT_EQ(answers_.Begin("user:2", "other", "hash", At(5000)).value()->body, "theirs");
}

TEST_P(IdempotencyStoreTest, LongAnswersOfAnOwnerHaveABudget) {
  const std::string half(IdempotencyStore::kLettersOfOwnerMax / 2, 'x');
  for (int i = 1; i <= 3; ++i) Answer(i, half);
  EXPECT_FALSE(Remembers("key-1"));
  EXPECT_TRUE(Remembers("key-2"));
  Answer(4, half + half + "x");
  EXPECT_TRUE(Remembers("key-4")) << "the newest is always there";
  EXPECT_FALSE(Remembers("key-3"));
}

INSTANTIATE_TEST_SUITE_P(Engines, IdempotencyStoreTest, tests::kBothEngines, tests::EngineName);

}  // namespace
}  // namespace faultlab::server

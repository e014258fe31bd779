#include "server/storage/blob_store.h"

#include <gmock/gmock.h>

#include "tests/support/engines.h"
#include "tests/support/test_database.h"

namespace faultlab::server {
namespace {

using core::Done;
using core::Status;
using testing::ElementsAre;

class BlobStore : public testing::TestWithParam<Engine> {
 protected:
  Status Put(const std::string& owner, std::int64_t sequence, const Bytes& bytes) {
    return database_->Write(Durability::kPromise, [&](Transaction& tx) -> Status {
      blob_store::Put(tx, owner, sequence, bytes);
      return Done{};
    });
  }
  std::optional<Bytes> Get(const std::string& owner, std::int64_t sequence) {
    return database_
        ->Read([&](Transaction& tx) -> core::Result<std::optional<Bytes>> {
          return blob_store::Get(tx, owner, sequence);
        })
        .value();
  }
  tests::TestDatabase database_{GetParam()};
};

Bytes AllByteValues(std::size_t size) {
  Bytes bytes;
  for (std::size_t i = 0; i < size; ++i) bytes.push_back(static_cast<std::byte>(i * 7 % 256));
  return bytes;
}

TEST_P(BlobStore, GivesBackBytesOfEverySize) {
  std::int64_t sequence = 0;
  for (const std::size_t size : {0u, 1u, 255u, 4096u, 1u << 20}) {
    const Bytes bytes = AllByteValues(size);
    ASSERT_TRUE(Put("a", sequence, bytes).ok());
    EXPECT_EQ(Get("a", sequence), bytes) << size;
    ++sequence;
  }
}

TEST_P(BlobStore, FindsNothingUnderAnotherOwnerOrSequence) {
  ASSERT_TRUE(Put("a", 5, AllByteValues(3)).ok());
  EXPECT_EQ(Get("b", 5), std::nullopt);
  EXPECT_EQ(Get("a", 4), std::nullopt);
  EXPECT_EQ(Get("a", 6), std::nullopt);
}

TEST_P(BlobStore, RefusesToReplace) {
  ASSERT_TRUE(Put("a", 5, AllByteValues(3)).ok());
  const Status second = Put("a", 5, AllByteValues(4));
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.error().code, core::ErrorCode::kConflict);
  EXPECT_EQ(Get("a", 5), AllByteValues(3));
}

TEST_P(BlobStore, VisitsARangeInOrderAndStopsWhenToldTo) {
  for (const std::int64_t sequence : {300, 100, 0, 200}) {
    ASSERT_TRUE(Put("a", sequence, AllByteValues(4)).ok());
  }
  ASSERT_TRUE(Put("other", 150, AllByteValues(4)).ok());
  std::vector<std::int64_t> seen;
  std::vector<std::int64_t> first_only;
  const Status status = database_->Read([&](Transaction& tx) -> Status {
    blob_store::ForEach(tx, "a", 100, 300, [&](std::int64_t sequence, const Bytes&) {
      seen.push_back(sequence);
      return true;
    });
    blob_store::ForEach(tx, "a", 0, 1000, [&](std::int64_t sequence, const Bytes&) {
      first_only.push_back(sequence);
      return false;
    });
    EXPECT_EQ(blob_store::SequenceAtOrBefore(tx, "a", 199), 100);
    EXPECT_EQ(blob_store::SequenceAtOrBefore(tx, "a", -1), std::nullopt);
    return Done{};
  });
  ASSERT_TRUE(status.ok()) << status.error().message;
  EXPECT_THAT(seen, ElementsAre(100, 200));
  EXPECT_THAT(first_only, ElementsAre(0));
}

TEST_P(BlobStore, LeavesNothingWhenTheTransactionFails) {
  const Status status = database_->Write(Durability::kPromise, [&](Transaction& tx) -> Status {
    blob_store::Put(tx, "a", 1, AllByteValues(9));
    return core::Error{core::ErrorCode::kInvalid, "changed my mind", ""};
  });
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(Get("a", 1), std::nullopt);
}

INSTANTIATE_TEST_SUITE_P(Engines, BlobStore, tests::kBothEngines, tests::EngineName);

}  // namespace
}  // namespace faultlab::server

#pragma once

#include <gtest/gtest.h>
#include <soci/soci.h>

#include <atomic>
#include <boost/json.hpp>
#include <string>

#include "tests/server/api/api_world.h"
#include "tests/support/await.h"

namespace faultlab::server {

inline constexpr const char* kRa =
    R"({"items":[{"component":"Ra","values":[9.8124738261],"onset_from_s":8.25}],
                                "healthy_share":0})";

/// A course: ann attends it, mila teaches it.
class TrialTest : public ApiTest {
 protected:
  explicit TrialTest(const Clock& clock = kSystemClock) : ApiTest(clock) {
    ann_ = Make("ann", Role::kStudent);
    mila_ = Make("mila", Role::kInstructor);
    course_ = MakeCourse("mila", "ann").id;
  }

  std::int64_t MakeSet(const std::string& pool) {
    const boost::json::object set = Ok(
        Call(mila_,
             "POST fault-sets",
             R"({"name":"pool","course":)" + std::to_string(course_) + R"(,"pool":)" + pool + "}"),
        201);
    return set.at("id").as_int64();
  }
  tests::HttpAnswer TryAssignment(std::int64_t set, const std::string& more) {
    return Call(mila_,
                "POST assignments",
                R"({"name":"Exercise","course":)" + std::to_string(course_) + R"(,"fault_set":)" +
                    std::to_string(set) + R"(,"due":")" + In(std::chrono::minutes(60)) + "\"" +
                    more + "}");
  }
  std::int64_t Assign(const std::string& pool, const std::string& more) {
    return Ok(TryAssignment(MakeSet(pool), more), 201).at("id").as_int64();
  }
  tests::HttpAnswer TryStart(const Person& who, std::int64_t assignment) {
    return Call(who, "POST assignments/" + std::to_string(assignment) + "/trials", "{}");
  }
  /// Begun, and its run over.
  boost::json::object Play(std::int64_t assignment) {
    const boost::json::object trial = Ok(TryStart(ann_, assignment), 201);
    application_->runs().Wait(Text(trial, "run"));
    return trial;
  }
  boost::json::object Trial(const Person& who, std::int64_t id) {
    return Ok(Call(who, "GET trials/" + std::to_string(id)));
  }
  tests::HttpAnswer Answer(const Person& who, std::int64_t id, const std::string& answer) {
    return Call(who, "POST trials/" + std::to_string(id) + "/answer", answer);
  }
  void MakeDue(std::int64_t assignment, const std::string& due_ms = "1") {
    const core::Status done =
        database_->Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
          tx.sql() << "UPDATE assignment SET due_ms = " + due_ms +
                          " WHERE id = " + std::to_string(assignment);
          return core::Done{};
        });
    ASSERT_TRUE(done.ok()) << done.error().message;
  }

  Person ann_;
  Person mila_;
  std::int64_t course_ = 0;
};

/// The machine's, ahead by what the test lets pass, or by what somebody sets it to.
class PassingClock : public SystemClock {
 public:
  MonotonicTime Monotonic() const override {
    return SystemClock::Monotonic() + std::chrono::milliseconds(passed_ms_.load());
  }
  WallTime Wall() const override {
    return SystemClock::Wall() + std::chrono::milliseconds(passed_ms_.load() + set_ms_.load());
  }
  void Pass(std::chrono::milliseconds time) {
    passed_ms_ += time.count();
    Moved();
  }
  void SetAhead(std::chrono::milliseconds time) { set_ms_ = time.count(); }

 private:
  std::atomic<std::int64_t> passed_ms_{0};
  std::atomic<std::int64_t> set_ms_{0};
};

struct HasClock {
  PassingClock time_;
};

class PassingTrialTest : protected HasClock, public TrialTest {
 protected:
  PassingTrialTest() : TrialTest(time_) {}
};

inline constexpr const char* kAtOnce =
    R"(,"reveal":"answer","attempts":2,"plan":{"duration_s":14})";
inline constexpr const char* kRight =
    R"({"component":"Ra","value":9.8,"unit":"ohm","confidence":0.9,"at_s":8.2,"text":"ia falls"})";

}  // namespace faultlab::server

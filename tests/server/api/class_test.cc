// A class in a blind exercise: all at once, and over a week.
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <map>
#include <random>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "server/api/iso8601.h"
#include "server/course/commitment.h"
#include "tests/server/api/trial_world.h"
#include "tests/support/scale.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using std::chrono::hours;

constexpr const char* kPool = R"({"healthy_share":0.2,"items":[
  {"component":"R1","values":[10,56,100],"onset_from_s":8,"onset_to_s":10},
  {"component":"Ra","low":9,"high":30,"onset_from_s":8,"onset_to_s":10},
  {"component":"J","low":4e-6,"high":2e-5,"onset_from_s":8,"onset_to_s":10},
  {"component":"C8","values":[1e-6,1e-5],"onset_from_s":8,"onset_to_s":10}]})";

/// Students who guess, each in their own way.
class ClassTest : public TrialTest {
 protected:
  struct Student {
    Person who;
    std::int64_t trial = 0;
    std::string answer;
    std::string commitment;
    std::string grade;
  };

  void Play(std::int64_t assignment, Student& student) {
    json::object begun;
    // A lab that is full says so, and has a place in a moment.
    EXPECT_TRUE(tests::Await([&] {
      const tests::HttpAnswer answer = TryStart(student.who, assignment);
      if (answer.status == 201) begun = json::parse(answer.body).as_object();
      if (answer.status == 201) return true;
      const std::string reason = ReasonOf(answer);
      EXPECT_TRUE(reason == "in_line" || answer.status == 429) << answer.body;
      return false;
    }));
    if (begun.empty()) return;
    student.trial = begun.at("id").as_int64();
    student.commitment = begun.at("commitment").as_string();
    application_->runs().Wait(Text(begun, "run"));
    student.grade = GradeFor(student);
  }
  std::string GradeFor(const Student& student) {
    const json::object answered = Ok(Answer(student.who, student.trial, student.answer));
    if (!answered.contains("grade")) return "";
    EXPECT_EQ(course::CommitmentOf(Text(answered, "nonce"), Text(answered, "truth")),
              student.commitment);
    return json::serialize(answered.at("grade"));
  }
};

TEST_F(ClassTest, AllFinishAndASecondGradingGivesTheSame) {
  const std::int64_t assignment = Assign(kPool, kAtOnce);
  const std::size_t count = tests::Proving() ? 250 : 8;
  std::vector<Student> students(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::string login = "student" + std::to_string(i);
    students[i].who = Make(login, Role::kStudent);
    ASSERT_TRUE(accounts_->Enrol(course_, AccountOf(login), false).ok());
    constexpr std::array kSaid = {R"("component":"R1","value":50,"unit":"ohm")",
                                  R"("component":"Ra","value":12,"unit":"ohm")",
                                  R"("component":null)"};
    students[i].answer = "{" + std::string(kSaid[i % kSaid.size()]) + R"(,"confidence":0.)" +
                         std::to_string(1 + i % 9) + "}";
  }
  std::vector<std::thread> threads;
  constexpr std::size_t kAtATime = 4;
  for (std::size_t first = 0; first < kAtATime; ++first) {
    threads.emplace_back([&, first] {
      for (std::size_t i = first; i < count; i += kAtATime) Play(assignment, students[i]);
    });
  }
  for (std::thread& thread : threads) thread.join();
  std::set<std::string> commitments;
  for (const Student& student : students) commitments.insert(student.commitment);
  EXPECT_EQ(commitments.size(), count);
  const core::Status undone =
      database_->Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
        tx.sql() << "UPDATE trial SET state = 'open', answer = '', grade = '', answered_ms = 0, "
                    "released_ms = 0";
        return core::Done{};
      });
  ASSERT_TRUE(undone.ok());
  for (const Student& student : students) EXPECT_EQ(GradeFor(student), student.grade);
  const json::object statistics =
      Ok(Call(mila_, "GET assignments/" + std::to_string(assignment) + "/statistics"));
  EXPECT_EQ(statistics.at("answered"), static_cast<std::int64_t>(count));
}

/// Students who begin, answer, are late or forget, each in their own hours.
class WeekTest : public PassingTrialTest {
 protected:
  static constexpr hours kDue{6 * 24};
  static constexpr hours kLate{24};
  static constexpr const char* kUsual = R"({"late_h":24,"late_percent_a_day":25})";

  struct Student {
    std::string login;
    std::int64_t trial = 0;
    bool answered = false;
    bool late = false;
  };
  struct Act {
    hours at{};
    std::size_t student = 0;
    bool answers = false;
  };

  WeekTest() : begin_(clock_.Wall()), random_(20261126) {
    json::object body{{"name", "A week"},
                      {"course", course_},
                      {"fault_set", MakeSet(kPool)},
                      {"due", Iso8601(begin_ + kDue)},
                      {"plan", json::object{{"duration_s", 14}}},
                      {"rubric", json::parse(kUsual)}};
    const json::object made = Ok(Call(mila_, "POST assignments", json::serialize(body)), 201);
    assignment_ = made.at("id").as_int64();
    path_ = "assignments/" + std::to_string(assignment_);
  }
  void PassUntil(hours at) {
    const auto left = begin_ + at - clock_.Wall();
    if (left > left.zero()) time_.Pass(std::chrono::ceil<std::chrono::milliseconds>(left));
  }
  std::vector<Act> ActsOf(std::size_t count) {
    std::vector<Act> acts;
    for (std::size_t i = 0; i < count; ++i) {
      const hours begins(random_() % 160);
      acts.push_back({begins, i, false});
      if (i % 9 != 8) acts.push_back({begins + hours(1 + random_() % 40), i, true});
    }
    std::ranges::stable_sort(acts, {}, &Act::at);
    return acts;
  }
  void Begin(const Act& act, Student& student) {
    const tests::HttpAnswer begun = TryStart(SignIn(student.login, clock_.Wall()), assignment_);
    if (act.at >= kDue + kLate) {
      EXPECT_EQ(ReasonOf(begun), "assignment_closed");
      return;
    }
    const json::object trial = Ok(begun, 201);
    student.trial = trial.at("id").as_int64();
    application_->runs().Wait(Text(trial, "run"));
  }
  void Say(const Act& act, Student& student) {
    if (student.trial == 0) return;  // began too late
    const Person who = SignIn(student.login, clock_.Wall());
    constexpr std::array kSaid = {R"({"component":"R1","value":50,"unit":"ohm","confidence":0.6})",
                                  R"({"component":"Ra","value":12,"unit":"ohm","confidence":0.9})",
                                  R"({"component":null,"confidence":0.3})"};
    const tests::HttpAnswer given = Answer(who, student.trial, kSaid[act.student % kSaid.size()]);
    if (act.at >= kDue + kLate) {
      EXPECT_EQ(ReasonOf(given), "answer_late");
      return;
    }
    const json::object answered = Ok(given);
    EXPECT_TRUE(answered.at("truth").is_null()) << "others have not answered";
    EXPECT_TRUE(answered.at("grade").is_null());
    student.answered = true;
    student.late = act.at >= kDue;
  }
  std::map<std::int64_t, json::object> Grades() {
    std::map<std::int64_t, json::object> grades;
    const Person teacher = SignIn("mila", clock_.Wall());
    std::string cursor;
    do {
      const json::object page = Ok(Call(teacher, "GET " + path_ + "/trials?limit=100" + cursor));
      for (const json::value& each : page.at("items").as_array()) {
        EXPECT_FALSE(each.at("truth").is_null()) << "all is released";
        if (each.at("state") != "answered") continue;
        grades[each.at("id").as_int64()] = each.at("grade").as_object();
      }
      const json::value& next = page.at("next_cursor");
      cursor = next.is_string() ? "&cursor=" + std::string(next.as_string()) : "";
    } while (!cursor.empty());
    return grades;
  }
  void SetRubric(const char* rubric, int version) {
    Ok(Call(SignIn("mila", clock_.Wall()),
            "PATCH " + path_,
            R"({"rubric":)" + std::string(rubric) + "}",
            IfMatch(version)));
  }

  const WallTime begin_;
  std::mt19937_64 random_;
  std::int64_t assignment_ = 0;
  std::string path_;
};

TEST_F(WeekTest, EndsWithAGradeForEveryAnswerAndTheSameASecondTime) {
  const std::size_t count = tests::Proving() ? 250 : 12;
  std::vector<Student> students(count);
  for (std::size_t i = 0; i < count; ++i) {
    students[i].login = "student" + std::to_string(i);
    Make(students[i].login, Role::kStudent);
    const auto account = AccountOf(students[i].login);
    ASSERT_TRUE(accounts_->Enrol(course_, account, false).ok());
  }
  bool restarted = false;
  for (const Act& act : ActsOf(count)) {
    PassUntil(act.at);
    if (!restarted && act.at > kDue / 2) {
      Restart();  // in the middle of the week
      restarted = true;
    }
    Student& student = students[act.student];
    act.answers ? Say(act, student) : Begin(act, student);
  }
  PassUntil(kDue + kLate + hours(48));
  const auto first = Grades();
  std::size_t answered = 0, late = 0;
  for (const Student& student : students) {
    EXPECT_EQ(first.contains(student.trial), student.answered) << student.login;
    if (!student.answered) continue;
    ++answered;
    late += student.late ? 1 : 0;
    EXPECT_EQ(first.at(student.trial).at("late_percent").to_number<double>(),
              student.late ? 25.0 : 0.0)
        << student.login;
  }
  EXPECT_GT(answered, count / 2);
  EXPECT_GT(late, 0U) << "the week has such students";
  EXPECT_EQ(Ok(Call(SignIn("mila", clock_.Wall()), "GET " + path_ + "/statistics")).at("answered"),
            static_cast<std::int64_t>(answered));
  SetRubric(R"({"detection":1,"isolation":0,"value":0,"confidence":0})", 1);
  const auto other = Grades();
  EXPECT_NE(other, first);
  SetRubric(kUsual, 2);
  EXPECT_EQ(Grades(), first) << "graded again from the recordings";
}

TEST_F(WeekTest, AServerThatStopsGivesTheAttemptBack) {
  PlayAtSpeed(4.0);
  const std::int64_t assignment = Assign(kPool, R"(,"plan":{"duration_s":600})");
  const json::object begun = Ok(TryStart(ann_, assignment), 201);
  const std::string run = Text(begun, "run");
  EXPECT_TRUE(
      tests::Await([&] { return Ok(Call(ann_, "GET runs/" + run)).at("samples").as_int64() > 0; }));
  Restart();
  EXPECT_EQ(Trial(ann_, begun.at("id").as_int64()).at("void"), "interrupted");
  EXPECT_EQ(TryStart(ann_, assignment).status, 201) << "it was the only attempt";
}

}  // namespace
}  // namespace faultlab::server

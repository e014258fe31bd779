// Blind trials over HTTP.
#include "server/course/commitment.h"
#include "tests/server/api/trial_world.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

TEST_F(TrialTest, IsDrawnPlayedAnsweredGradedAndOpened) {
  const std::int64_t assignment = Assign(kRa, kAtOnce);
  const json::object begun = Play(assignment);
  const std::int64_t id = begun.at("id").as_int64();
  const std::string run = Text(begun, "run");
  const json::object open = Trial(ann_, id);
  EXPECT_EQ(open.at("state"), "open");
  EXPECT_TRUE(open.at("truth").is_null());
  EXPECT_EQ(ReasonOf(TryStart(ann_, assignment)), "trial_open");

  const json::object answered = Ok(Answer(ann_, id, kRight));
  EXPECT_EQ(answered.at("state"), "answered");
  EXPECT_EQ(answered.at("commitment"), begun.at("commitment"));
  const std::string truth = Text(answered, "truth");
  EXPECT_EQ(course::CommitmentOf(Text(answered, "nonce"), truth), Text(begun, "commitment"));
  const json::object& grade = answered.at("grade").as_object();
  EXPECT_EQ(grade.at("right"), true);
  EXPECT_NEAR(grade.at("points").to_number<double>(), 99.9, 0.05) << "0.1 for its confidence";
  EXPECT_GT(grade.at("bound").to_number<double>(), 0.0);
  EXPECT_LT(grade.at("bound").to_number<double>(), 0.05);

  // The run is now as any other: plan, events and the lab's own diagnosis.
  const json::object opened = Ok(Call(ann_, "GET runs/" + run));
  EXPECT_FALSE(opened.at("plan").as_object().contains("sealed"));
  EXPECT_EQ(opened.at("plan").at("faults").at(0).at("component"), "Ra");
  EXPECT_EQ(opened.at("plan").at("trial"), id);
  std::vector<std::string> kinds;
  std::int64_t before = 0;
  for (const json::value& event : opened.at("events").as_array()) {
    kinds.emplace_back(event.at("kind").as_string());
    EXPECT_GE(event.at("index").to_number<std::int64_t>(), before);
    before = event.at("index").to_number<std::int64_t>();
  }
  EXPECT_EQ(
      kinds,
      (std::vector<std::string>{
          "started", "fault_commanded", "relay_confirmed", "detected", "isolated", "finished"}))
      << "what the lab would have told live is there too";
  const json::object diagnosis = Ok(Call(ann_, "GET runs/" + run + "/diagnosis"));
  EXPECT_EQ(diagnosis.at("verdict"), "fault");
  EXPECT_EQ(diagnosis.at("candidates").at(0).at("component"), "Ra");

  EXPECT_EQ(ReasonOf(Answer(ann_, id, kRight)), "trial_changed");
  Play(assignment);
  EXPECT_EQ(ReasonOf(TryStart(ann_, assignment)), "trial_open");
}

TEST_F(TrialTest, IsReleasedWhenItIsDueWhateverWasAnswered) {
  const std::int64_t assignment = Assign(kRa, R"(,"attempts":2,"plan":{"duration_s":14})");
  const std::int64_t one = Play(assignment).at("id").as_int64();
  const json::object answered = Ok(Answer(ann_, one, R"({"component":null,"confidence":1})"));
  EXPECT_TRUE(answered.at("grade").is_null()) << "a grade tells the truth";
  EXPECT_TRUE(answered.at("truth").is_null());
  const std::int64_t two = Play(assignment).at("id").as_int64();
  MakeDue(assignment);
  EXPECT_EQ(ReasonOf(Answer(ann_, two, kRight)), "answer_late");
  EXPECT_EQ(ReasonOf(TryStart(ann_, assignment)), "assignment_closed");
  EXPECT_EQ(Trial(ann_, one).at("grade").at("points").to_number<double>(), 0.0);
  EXPECT_EQ(Trial(ann_, two).at("state"), "open") << "never answered";
  EXPECT_FALSE(Trial(ann_, two).at("truth").is_null());
  const tests::HttpAnswer csv =
      Call(mila_, "GET assignments/" + std::to_string(assignment) + "/grades.csv?each=trial");
  EXPECT_NE(csv.body.find("\"healthy\",\"\",\"1\",\"Ra = 9.8124738261\",0"), std::string::npos)
      << csv.body;
}

TEST_F(TrialTest, AnAnswerSaysWhyInLinesAndMarksWhatShowsIt) {
  const std::int64_t assignment = Assign(kRa, kAtOnce);
  const std::int64_t id = Play(assignment).at("id").as_int64();
  const auto with = [](const std::string& evidence) {
    return R"({"component":"Ra","value":9.8,"unit":"ohm","confidence":0.9,"text":"ia falls,\nn too",)"
           R"("evidence":)" +
           evidence + "}";
  };
  EXPECT_EQ(ReasonOf(Answer(ann_, id, with(R"([{"from_s":9,"to_s":8}])"))), "pool_range_backwards");
  EXPECT_EQ(ReasonOf(Answer(ann_, id, with(R"([{"from_s":9}])"))), "member_missing");
  EXPECT_EQ(ReasonOf(Answer(ann_, id, with("[5]"))), "kind_wrong");
  EXPECT_EQ(ReasonOf(Answer(ann_, id, with(R"([{"from_s":9,"to_s":1e9}])"))), "number_outside");
  const json::object answered =
      Ok(Answer(ann_, id, with(R"([{"from_s":8.2,"to_s":9},{"from_s":12,"to_s":12}])")));
  const json::object& answer = answered.at("answer").as_object();
  EXPECT_EQ(answer.at("text"), "ia falls,\nn too");
  EXPECT_EQ(answer.at("evidence").as_array().size(), 2U);
  EXPECT_EQ(answer.at("evidence").at(0).at("to_s").to_number<double>(), 9.0);
}

TEST_F(TrialTest, AHintIsTheLabsAndCostsPoints) {
  const auto take = [&](const Person& who, std::int64_t id, int number) {
    return Call(who, "PUT trials/" + std::to_string(id) + "/hints/" + std::to_string(number));
  };
  const std::int64_t without = Play(Assign(kRa, kAtOnce)).at("id").as_int64();
  EXPECT_EQ(ReasonOf(take(ann_, without, 1)), "no_hints");

  const std::int64_t assignment =
      Assign(kRa, R"(,"attempts":2,"plan":{"duration_s":14},"rubric":{"hint_percent":10})");
  const std::int64_t id = Play(assignment).at("id").as_int64();
  EXPECT_EQ(ReasonOf(take(mila_, id, 1)), "trial_of_another");
  EXPECT_EQ(ReasonOf(take(ann_, id, 2)), "hint_not_next");
  const json::object one = Ok(take(ann_, id, 1));
  ASSERT_EQ(one.at("hints").as_array().size(), 1U);
  EXPECT_NEAR(one.at("hints").at(0).at("at_s").to_number<double>(), 8.3, 0.1);
  EXPECT_TRUE(one.at("truth").is_null());
  EXPECT_EQ(json::serialize(Ok(take(ann_, id, 1))), json::serialize(one))
      << "sent twice, paid once";
  const json::object two = Ok(take(ann_, id, 2));
  const json::array& parts = two.at("hints").at(1).at("components").as_array();
  ASSERT_EQ(parts.size(), 3U);
  EXPECT_EQ(std::ranges::count(parts, json::value("Ra")), 1);
  EXPECT_EQ(ReasonOf(take(ann_, id, 3)), "hint_not_next");
  Ok(Answer(ann_, id, kRight));
  MakeDue(assignment);
  const json::object graded = Trial(ann_, id);
  EXPECT_NEAR(graded.at("points").to_number<double>(), 0.8 * 99.9, 0.06);
  EXPECT_EQ(graded.at("grade").at("hint_percent").to_number<double>(), 20.0);
  EXPECT_EQ(Ok(take(ann_, id, 2)).at("hints").as_array().size(), 2U) << "which it has";
}

TEST_F(TrialTest, IsTakenLateForFewerPointsAndReleasedWhenThatIsOver) {
  const std::int64_t assignment = Assign(
      kRa,
      R"(,"attempts":2,"plan":{"duration_s":14},"rubric":{"late_h":48,"late_percent_a_day":25})");
  const std::string path = "assignments/" + std::to_string(assignment);
  const std::int64_t one = Play(assignment).at("id").as_int64();
  const auto hours_ago = [](int hours) {
    return std::to_string((Now() - std::chrono::hours(hours)).time_since_epoch().count());
  };
  MakeDue(assignment, hours_ago(30));  // a day and a quarter
  const json::object shown = Ok(Call(ann_, "GET " + path));
  EXPECT_LT(shown.at("your_due").as_string(), shown.at("your_close").as_string());
  EXPECT_TRUE(Trial(ann_, one).at("truth").is_null()) << "it is due and not over";
  EXPECT_TRUE(Ok(Answer(ann_, one, kRight)).at("grade").is_null());
  const std::int64_t two = Play(assignment).at("id").as_int64();
  MakeDue(assignment, hours_ago(49));
  EXPECT_EQ(ReasonOf(Answer(ann_, two, kRight)), "answer_late");
  EXPECT_EQ(ReasonOf(TryStart(ann_, assignment)), "assignment_closed");
  const json::object grade = Trial(ann_, one).at("grade").as_object();
  EXPECT_EQ(grade.at("late_percent").to_number<double>(), 50.0) << "graded when it was given";
  EXPECT_NEAR(grade.at("points").to_number<double>(), 49.95, 0.06);
  EXPECT_FALSE(Trial(ann_, two).at("truth").is_null());

  const std::string person = std::to_string(AccountOf("ann"));
  Ok(Call(mila_,
          "PUT " + path + "/extensions/" + person,
          R"({"due":")" + In(std::chrono::minutes(60)) + "\"}"));
  const json::object anew = Trial(ann_, one).at("grade").as_object();
  EXPECT_EQ(anew.at("late_percent").to_number<double>(), 0.0) << "it was in time for her";
  EXPECT_GT(anew.at("points").to_number<double>(), 90.0);
}

TEST_F(TrialTest, AGradebookHasALineForEachStudentAndTheAttemptThatCounts) {
  const std::int64_t assignment = Assign(kRa, R"(,"attempts":2,"plan":{"duration_s":14})");
  const std::string path = "assignments/" + std::to_string(assignment);
  Make("eva", Role::kStudent);
  ASSERT_TRUE(accounts_->Enrol(course_, AccountOf("eva"), false).ok());
  const auto book = [&](const std::string& query) {
    return Call(mila_, "GET " + path + "/grades.csv" + query).body;
  };
  const std::int64_t one = Play(assignment).at("id").as_int64();
  Ok(Answer(ann_, one, kRight));
  const std::int64_t two = Play(assignment).at("id").as_int64();
  Ok(Answer(ann_, two, R"({"component":null,"confidence":1})"));
  const auto row = [](std::int64_t trial) {
    return ",2," + std::to_string(trial) + ",answered,0,";
  };
  EXPECT_THAT(book(""), testing::HasSubstr(",," + row(one))) << "not released";
  MakeDue(assignment);
  EXPECT_THAT(book(""),
              testing::StartsWith("id,login,name,points,percent,attempts,trial,state,late_percent,"
                                  "overridden,answered_at\r\n"));
  EXPECT_THAT(book(""), testing::ContainsRegex("\"ann\",[^\r]*,9[0-9.]*,9[0-9.]*%" + row(one)));
  EXPECT_THAT(book(""), testing::ContainsRegex("\"eva\",[^\r]*,,,0,,not_begun,0,no,\r"));
  EXPECT_THAT(book("?for=excel"), testing::StartsWith("\xEF\xBB\xBFid,"));
  EXPECT_THAT(book("?for=excel_comma"), testing::StartsWith("\xEF\xBB\xBFid;"));
  EXPECT_THAT(book("?for=excel_comma"),
              testing::ContainsRegex("\"ann\";[^\r]*;9[0-9,]*;9[0-9,]*%;"));
  EXPECT_THAT(book("?for=moodle"), testing::StartsWith("Username,\"Full name\",\""));
  EXPECT_THAT(book("?for=moodle"), testing::Not(testing::HasSubstr("eva")))
      << "an empty field would clear what a teacher has entered";
  EXPECT_THAT(book("?for=canvas"), testing::HasSubstr("    Points Possible,,,,,100\r\n"));
  EXPECT_EQ(ReasonOf(Call(mila_, "GET " + path + "/grades.csv?for=blackboard")), "word_unknown");
  Ok(Call(
      mila_,
      "PATCH " + path,
      R"({"opens":"2020-01-01T00:00:00Z","due":"2020-01-02T00:00:00Z","rubric":{"counts":"last"}})",
      IfMatch(1)));
  EXPECT_THAT(book(""), testing::HasSubstr(",0,0%" + row(two)));
}

TEST_F(TrialTest, OneStudentHasMoreTimeAndWhoHasSeenTheTruthAnswersNoMore) {
  const std::int64_t assignment = Assign(kRa, R"(,"plan":{"duration_s":14})");
  const std::string path = "assignments/" + std::to_string(assignment);
  const std::int64_t id = Play(assignment).at("id").as_int64();
  const std::string person = std::to_string(AccountOf("ann"));
  const auto change = [&](const std::string& body, int version) {
    return Call(mila_, "PATCH " + path, body, IfMatch(version));
  };
  const json::object extended = Ok(Call(mila_,
                                        "PUT " + path + "/extensions/" + person,
                                        R"({"due":")" + In(std::chrono::minutes(120)) + "\"}"));
  EXPECT_EQ(extended.at("extensions").as_array().size(), 1U);
  EXPECT_EQ(ReasonOf(Call(mila_,
                          "PUT " + path + "/extensions/" + person,
                          R"({"due":")" + In(std::chrono::minutes(1)) + "\"}")),
            "extension_not_later");
  const std::string past =
      R"({"opens":"2020-01-01T00:00:00Z","due":"2020-01-02T00:00:00Z","name":"Renamed"})";
  EXPECT_EQ(Ok(change(past, 1)).at("version"), 2);
  EXPECT_EQ(ReasonOf(change(past, 1)), "assignment_changed");
  EXPECT_EQ(ReasonOf(change(R"({"due":"2019-01-01T00:00:00Z"})", 2)), "due_not_ahead");
  EXPECT_EQ(ReasonOf(change(R"({"plan":{}})", 2)), "member_unknown");
  const json::object hers = Ok(Call(ann_, "GET " + path));
  EXPECT_EQ(hers.at("name"), "Renamed");
  EXPECT_NE(hers.at("your_due"), hers.at("due"));
  EXPECT_TRUE(hers.at("extensions").is_null()) << "of others";
  EXPECT_TRUE(Trial(ann_, id).at("truth").is_null()) << "not due for her";
  const tests::HttpAnswer ended = Call(mila_, "DELETE " + path + "/extensions/" + person);
  EXPECT_EQ(ended.status, 200) << ended.body;
  EXPECT_FALSE(Trial(ann_, id).at("truth").is_null());
  EXPECT_EQ(Ok(change(R"({"due":")" + In(std::chrono::minutes(60)) + "\"}", 2)).at("version"), 3);
  EXPECT_EQ(ReasonOf(Answer(ann_, id, kRight)), "answer_late") << "she has read the truth";
  EXPECT_EQ(
      Call(mila_, "PUT " + path + "/extensions/99", R"({"due":"2099-01-01T00:00:00Z"})").status,
      404);
}

TEST_F(TrialTest, ATeachersPointsCountWithTheirReason) {
  const std::int64_t assignment = Assign(kRa, R"(,"plan":{"duration_s":14})");
  const std::int64_t id = Play(assignment).at("id").as_int64();
  const std::string path = "trials/" + std::to_string(id) + "/points";
  const auto award = [&](const Person& who, const std::string& body) {
    return Call(who, "PUT " + path, body);
  };
  const std::string good = R"({"points":80,"reason":"the chart, \"misleading\""})";
  Ok(Answer(ann_, id, R"({"component":"R1","value":56,"unit":"ohm","confidence":0.5})"));
  EXPECT_EQ(ReasonOf(award(mila_, good)), "trial_not_released");
  MakeDue(assignment);
  const double graded = Trial(ann_, id).at("points").to_number<double>();
  EXPECT_LT(graded, 50.0);
  EXPECT_EQ(award(ann_, good).status, 403);
  EXPECT_EQ(ReasonOf(award(mila_, R"({"points":80,"reason":""})")), "member_missing");
  EXPECT_EQ(ReasonOf(award(mila_, R"({"points":101,"reason":"x"})")), "number_outside");
  EXPECT_EQ(Ok(award(mila_, good)).at("points").to_number<double>(), 80.0);
  EXPECT_EQ(Trial(ann_, id).at("awarded").at("by"), "mila");
  const std::string of = "assignments/" + std::to_string(assignment);
  const std::string csv = Call(mila_, "GET " + of + "/grades.csv?each=trial").body;
  EXPECT_NE(csv.find(R"(,80,"the chart, ""misleading""")"), std::string::npos) << csv;
  Ok(award(mila_, R"({"points":80,"reason":"=A1+1"})"));
  EXPECT_NE(Call(mila_, "GET " + of + "/grades.csv?each=trial").body.find(R"(,80,"'=A1+1")"),
            std::string::npos)
      << "no formula";
  const json::object statistics = Ok(Call(mila_, "GET " + of + "/statistics"));
  EXPECT_EQ(statistics.at("faults").at(0).at("component"), "Ra");
  EXPECT_EQ(statistics.at("faults").at(0).at("answers").at(0).at("component"), "R1");
  EXPECT_EQ(statistics.at("points").to_number<double>(), 80.0);
  EXPECT_EQ(Ok(Call(mila_, "DELETE " + path)).at("points").to_number<double>(), graded);
}

TEST_F(TrialTest, EachStudentChoosesTheExcitationWhereTheAssignmentSaysSo) {
  const auto start = [&](std::int64_t assignment, const std::string& body) {
    return Call(ann_, "POST assignments/" + std::to_string(assignment) + "/trials", body);
  };
  const std::string step = R"({"excitation":{"kind":"step","low_v":2,"high_v":3,"at_s":1}})";
  EXPECT_EQ(ReasonOf(start(Assign(kRa, kAtOnce), step)), "excitation_fixed");
  const std::int64_t assignment =
      Assign(kRa, R"(,"attempts":2,"plan":{"duration_s":14,"free_excitation":true})");
  const json::object shown = Ok(Call(ann_, "GET assignments/" + std::to_string(assignment)));
  EXPECT_EQ(shown.at("plan").at("free_excitation"), true);
  const tests::HttpAnswer wrong = start(assignment, R"({"excitation":{"kind":"noise"}})");
  EXPECT_EQ(wrong.status, 400) << wrong.body;
  const json::object begun = Ok(start(assignment, step), 201);
  const std::string run = Text(begun, "run");
  EXPECT_EQ(Ok(Call(ann_, "GET runs/" + run)).at("plan").at("excitation").at("kind"), "step");
  application_->runs().Wait(run);
  EXPECT_EQ(Ok(Answer(ann_, begun.at("id").as_int64(), kRight)).at("state"), "answered");
  Ok(start(assignment, "{}"), 201);
}

TEST_F(TrialTest, IsAnsweredWithinItsTime) {
  const std::int64_t assignment =
      Assign(kRa, R"(,"attempts":2,"plan":{"duration_s":14},"rubric":{"time_limit_min":25})");
  const std::int64_t one = Play(assignment).at("id").as_int64();
  const json::object open = Trial(ann_, one);
  EXPECT_LT(
      open.at("answer_by").as_string(),
      Ok(Call(ann_, "GET assignments/" + std::to_string(assignment))).at("your_close").as_string());
  const core::Status earlier =
      database_->Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
        tx.sql() << "UPDATE trial SET created_ms = created_ms - 25 * 60000";
        return core::Done{};
      });
  ASSERT_TRUE(earlier.ok());
  EXPECT_EQ(ReasonOf(Answer(ann_, one, kRight)), "answer_late");
  EXPECT_TRUE(Trial(ann_, one).at("truth").is_null()) << "others go on until it is due";
  const std::int64_t two = Play(assignment).at("id").as_int64();
  EXPECT_EQ(Ok(Answer(ann_, two, kRight)).at("state"), "answered");
  EXPECT_EQ(ReasonOf(TryStart(ann_, assignment)), "attempts_used") << "the first one counts";
  const json::object seen = Ok(Call(mila_, "GET assignments/" + std::to_string(assignment)));
  EXPECT_EQ(json::serialize(seen.at("progress")),
            R"({"students":1,"begun":1,"answered":1,"to_grade":0})");
}

TEST_F(TrialTest, AGroupSharesAttemptsTrialsAnswersAndPoints) {
  const std::int64_t assignment =
      Assign(kRa, R"(,"attempts":1,"group_max":2,"plan":{"duration_s":14})");
  const std::string path = "assignments/" + std::to_string(assignment);
  const auto join = [&](std::string_view login) {
    const Person who = Make(std::string(login), Role::kStudent);
    const auto account = AccountOf(std::string(login));
    EXPECT_TRUE(accounts_->Enrol(course_, account, false).ok());
    return who;
  };
  const Person eva = join("eva");
  const Person ivan = join("ivan");
  const Person late = join("late");
  const auto enter = [&](const Person& who, const std::string& body) {
    return Call(who, "POST " + path + "/group", body);
  };
  const std::string code(Ok(enter(ann_, "{}")).at("code").as_string());
  EXPECT_EQ(ReasonOf(enter(ann_, "{}")), "in_group");
  EXPECT_EQ(ReasonOf(enter(eva, R"({"code":"XXXXXX"})")), "group_unknown");
  const Person guesser = join("guesser");
  int guesses = 0;
  while (guesses < 50 && enter(guesser, R"({"code":"XXXXXX"})").status != 429) ++guesses;
  EXPECT_LE(guesses, 10) << "codes are not guessed at will";
  const std::string as_typed = code.substr(0, 3) + " " + code.substr(3);
  EXPECT_EQ(Ok(enter(eva, R"({"code":")" + as_typed + "\"}")).at("members").as_array().size(), 2U);
  EXPECT_EQ(ReasonOf(enter(ivan, R"({"code":")" + code + "\"}")), "group_full");
  EXPECT_EQ(Ok(Call(eva, "GET " + path)).at("group").at("code").as_string(), code);
  EXPECT_TRUE(Ok(Call(ivan, "GET " + path)).at("group").is_null());

  const json::object trial = Play(assignment);
  const std::int64_t id = trial.at("id").as_int64();
  const std::string run = Text(trial, "run");
  EXPECT_EQ(trial.at("members").as_array().size(), 2U);
  EXPECT_EQ(ReasonOf(TryStart(eva, assignment)), "trial_open") << "one trial of both";
  EXPECT_EQ(ReasonOf(Call(eva, "DELETE " + path + "/group")), "group_begun");
  EXPECT_EQ(Call(eva, "GET runs/" + run).status, 200);
  EXPECT_EQ(Call(eva, "GET runs/" + run + "/events").status, 200);
  EXPECT_EQ(Call(eva, "DELETE runs/" + run).status, 404) << "it is not hers";
  EXPECT_EQ(Call(ivan, "GET runs/" + run).status, 404);
  EXPECT_EQ(Trial(eva, id).at("state"), "open");
  EXPECT_EQ(Call(ivan, "GET trials/" + std::to_string(id)).status, 404);
  EXPECT_EQ(ReasonOf(enter(late, R"({"code":")" + code + "\"}")), "group_full");

  EXPECT_EQ(Ok(Answer(eva, id, kRight)).at("state"), "answered");
  EXPECT_EQ(ReasonOf(Answer(ann_, id, kRight)), "trial_changed");
  EXPECT_EQ(ReasonOf(TryStart(eva, assignment)), "attempts_used");
  MakeDue(assignment);
  EXPECT_GT(Trial(eva, id).at("points").to_number<double>(), 90.0);
  const std::string csv = Call(mila_, "GET " + path + "/grades.csv?each=trial").body;
  EXPECT_NE(csv.find("\"ann\""), std::string::npos) << csv;
  EXPECT_NE(csv.find("\"eva\""), std::string::npos) << "a line for each of them";
  EXPECT_EQ(csv.find("\"ivan\""), std::string::npos);
}

TEST_F(TrialTest, AGroupThatHasBegunTakesNobody) {
  const std::int64_t assignment = Assign(kRa, R"(,"group_max":3,"plan":{"duration_s":14})");
  const std::string path = "assignments/" + std::to_string(assignment) + "/group";
  const auto enter = [&](const Person& who, const std::string& body) {
    return Call(who, "POST " + path, body);
  };
  const std::string code(Ok(enter(ann_, "{}")).at("code").as_string());
  Play(assignment);
  const Person eva = Make("eva", Role::kStudent);
  ASSERT_TRUE(accounts_->Enrol(course_, AccountOf("eva"), false).ok());
  EXPECT_EQ(ReasonOf(enter(eva, R"({"code":")" + code + "\"}")), "group_begun");
  Ok(TryStart(eva, assignment), 201);
  EXPECT_EQ(ReasonOf(enter(eva, "{}")), "group_begun") << "she works alone already";
  const std::int64_t alone = Assign(kRa, R"(,"plan":{"duration_s":14})");
  EXPECT_EQ(ReasonOf(Call(eva, "POST assignments/" + std::to_string(alone) + "/group", "{}")),
            "groups_none");
}

TEST_F(TrialTest, AnswersAreGradedAgainByARubricThatHasChanged) {
  const std::int64_t assignment = Assign(kRa, kAtOnce);
  const std::int64_t id = Play(assignment).at("id").as_int64();
  Ok(Answer(ann_, id, R"({"component":"R1","value":56,"unit":"ohm","confidence":1})"));
  const double before = Trial(ann_, id).at("points").to_number<double>();
  const std::string path = "assignments/" + std::to_string(assignment);
  const auto change = [&](const std::string& rubric, int version) {
    return Call(mila_, "PATCH " + path, R"({"rubric":)" + rubric + "}", IfMatch(version));
  };
  EXPECT_EQ(ReasonOf(change(R"({"isolation":-1})", 1)), "number_outside");
  const json::object shown =
      Ok(change(R"({"detection":100,"isolation":0,"value":0,"confidence":0})", 1));
  EXPECT_EQ(shown.at("rubric").at("isolation").to_number<double>(), 0.0);
  EXPECT_LT(before, 50.0);
  EXPECT_EQ(Trial(ann_, id).at("points").to_number<double>(), 100.0) << "something had failed";
  Ok(change("{}", 2));
  EXPECT_EQ(Trial(ann_, id).at("points").to_number<double>(), before) << "as usual";
  // A recording that is gone keeps the grade it has.
  const std::string run(Trial(ann_, id).at("run").as_string());
  ASSERT_EQ(Call(ann_, "DELETE runs/" + run).status, 204);
  Ok(change(R"({"detection":100,"isolation":0,"value":0,"confidence":0})", 3));
  EXPECT_EQ(Trial(ann_, id).at("points").to_number<double>(), before);
}

TEST_F(TrialTest, IsGradedTheSameASecondTime) {
  const std::int64_t assignment = Assign(kRa, kAtOnce);
  const std::int64_t id = Play(assignment).at("id").as_int64();
  const json::value first = Ok(Answer(ann_, id, kRight)).at("grade");
  // As a second grading would find it: the answer is taken back behind the server's back.
  const core::Status undone =
      database_->Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
        tx.sql() << "UPDATE trial SET state = 'open', answer = '', grade = '', answered_ms = 0, "
                    "released_ms = 0";
        return core::Done{};
      });
  ASSERT_TRUE(undone.ok());
  EXPECT_EQ(json::serialize(Ok(Answer(ann_, id, kRight)).at("grade")), json::serialize(first));
}

TEST_F(TrialTest, IsSeenByItsStudentAndTheTeachersOfItsCourse) {
  const std::int64_t assignment = Assign(kRa, kAtOnce);
  const std::int64_t id = Play(assignment).at("id").as_int64();
  const Person bob = Make("bob", Role::kStudent);
  const Person ivo = Make("ivo", Role::kInstructor);
  const Person mate = Make("eva", Role::kStudent);
  ASSERT_TRUE(accounts_->Enrol(course_, AccountOf("eva"), false).ok());
  const auto status = [&](const Person& who) {
    return Call(who, "GET trials/" + std::to_string(id)).status;
  };
  EXPECT_EQ(status(ann_), 200);
  EXPECT_EQ(status(mila_), 200);
  EXPECT_EQ(status(bob), 404);
  EXPECT_EQ(status(mate), 404) << "of the same course";
  EXPECT_EQ(status(ivo), 404) << "teaches another";
  EXPECT_EQ(status({}), 401);
  EXPECT_EQ(TryStart(bob, assignment).status, 404);
  EXPECT_EQ(Answer(mila_, id, kRight).status, 403) << "not in their name";
  const std::string list = "assignments/" + std::to_string(assignment) + "/trials";
  EXPECT_EQ(Items(mate, list).size(), 0U);
  EXPECT_EQ(Items(mila_, list).size(), 1U);
  const json::object seen = Ok(Call(ann_, "GET assignments/" + std::to_string(assignment)));
  EXPECT_TRUE(seen.at("pool").is_null()) << "what may come is the teacher's to know";
  EXPECT_EQ(Items(ann_, "fault-sets").size(), 0U);
}

TEST_F(TrialTest, CannotBeMadeOfWhatNobodyCanSolve) {
  const auto reason = [&](const std::string& pool, const std::string& more) {
    return ReasonOf(TryAssignment(MakeSet(pool), more));
  };
  const std::string plan = R"(,"plan":{"duration_s":14})";
  EXPECT_EQ(
      reason(R"({"items":[{"component":"J","values":[0.00000143001],"onset_from_s":8}]})", plan),
      "fault_not_visible");
  EXPECT_EQ(reason(kRa, R"(,"plan":{"duration_s":9})"), "run_ends_with_fault");
  EXPECT_EQ(reason(kRa, R"(,"plan":{"seed":1})"), "member_unknown");
  EXPECT_EQ(reason(kRa, R"(,"plan":{"duration_s":14,"period_s":0.1})"), "clock_too_short");
  EXPECT_EQ(reason(kRa, R"(,"plan":{"duration_s":14,"period_s":0.001})"), "voltage_steps");
  EXPECT_EQ(reason(kRa, R"(,"plan":{"duration_s":14},"rubric":{"value":-1})"), "number_outside");
  EXPECT_EQ(reason(kRa, R"(,"plan":{"duration_s":14},"rubric":{"late_h":-1})"), "number_outside");
  EXPECT_EQ(ReasonOf(Call(mila_,
                          "POST assignments",
                          R"({"name":"E","course":1,"fault_set":)" + std::to_string(MakeSet(kRa)) +
                              R"(,"due":"2020-01-01T00:00:00Z"})")),
            "due_not_ahead");
  const json::object plain =
      Ok(Call(mila_,
              "POST fault-sets",
              R"({"name":"s","faults":[{"component":"R1","value":56,"at_s":8}]})"),
         201);
  EXPECT_EQ(ReasonOf(TryAssignment(plain.at("id").as_int64(), plan)), "set_without_pool");
  const std::int64_t pool = MakeSet(kRa);
  EXPECT_EQ(ReasonOf(Call(
                mila_, "POST runs", R"({"rig":"sim-1","fault_set":)" + std::to_string(pool) + "}")),
            "set_to_draw_from");
}

TEST_F(TrialTest, APreviewTellsTheTeacherWhatCanBeSeenOfIt) {
  const auto preview = [&](const Person& who, const std::string& items, const char* plan) {
    return Call(who,
                "POST assignments/preview",
                R"({"bench":"paper","pool":{"healthy_share":0,"items":[)" + items +
                    R"(]},"plan":)" + plan + "}");
  };
  const char* plan = R"({"duration_s":14})";
  const std::string nearly =
      R"({"component":"R1","values":[1.00001,56],"onset_from_s":8},{"component":"R9","values":[22000],"onset_from_s":8})";
  const json::object judged = Ok(preview(mila_, nearly, plan));
  const json::array& faults = judged.at("isolability").at("faults").as_array();
  ASSERT_EQ(faults.size(), 2U);
  EXPECT_EQ(faults[0].at("visible"), false) << "the nearest to nominal of R1";
  EXPECT_EQ(faults[1].at("visible"), true);
  EXPECT_EQ(faults[1].at("group").as_array().size(), 2U) << "R12 looks the same";
  // A quarter of the draws cannot be seen: half of detection, and a confidence of a half.
  const json::object& expected = judged.at("expected").as_object();
  EXPECT_EQ(expected.at("hardest").at("value").to_number<double>(), 1.00001);
  EXPECT_NEAR(expected.at("hardest").at("points").to_number<double>(), 52.5, 0.5);
  EXPECT_NEAR(expected.at("points").to_number<double>(), 88.1, 0.5);
  EXPECT_NEAR(expected.at("spread").to_number<double>(), 20.6, 0.5);
  EXPECT_EQ(ReasonOf(preview(mila_, nearly, R"({"duration_s":8.5})")), "run_ends_with_fault");
  EXPECT_EQ(ReasonOf(preview(mila_, "", plan)), "no_faults");
  EXPECT_EQ(preview(ann_, nearly, plan).status, 403);
}

TEST_F(TrialTest, OfADriftIsPlayedToItsEnd) {
  const std::int64_t assignment =
      Assign(R"({"healthy_share":0,"items":[{"component":"R1","values":[56],"onset_from_s":8,
                 "kind":"drift","lasts_s":3}]})",
             kAtOnce);
  const json::object trial = Play(assignment);
  EXPECT_EQ(Trial(ann_, trial.at("id").as_int64()).at("state"), "open");
  const json::object answered =
      Ok(Answer(ann_,
                trial.at("id").as_int64(),
                R"({"component":"R1","value":56,"unit":"ohm","confidence":1})"));
  EXPECT_EQ(answered.at("points").to_number<double>(), 100.0);
}

TEST_F(TrialTest, OutlivesItsFaultSet) {
  const std::int64_t set = MakeSet(kRa);
  const std::int64_t assignment = Ok(TryAssignment(set, kAtOnce), 201).at("id").as_int64();
  const tests::HttpAnswer gone =
      Call(mila_, "DELETE fault-sets/" + std::to_string(set), {}, IfMatch(1));
  EXPECT_EQ(gone.status, 204) << gone.body;
  const std::int64_t id = Play(assignment).at("id").as_int64();
  EXPECT_EQ(Ok(Answer(ann_, id, kRight)).at("grade").at("right"), true);
}

TEST_F(TrialTest, GivesTheAttemptBackWhenItsServerDied) {
  const std::int64_t assignment = Assign(kRa, R"(,"plan":{"duration_s":14})");
  const json::object begun = Play(assignment);
  const auto set = [&](const std::string& what) {
    const core::Status done =
        database_->Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
          tx.sql() << what;
          return core::Done{};
        });
    EXPECT_TRUE(done.ok());
  };
  // Between the draw and the begin of its run; then in the middle of the run.
  set("UPDATE trial SET state = 'drawn', run = '', ended_ms = 0");
  EXPECT_EQ(Trial(ann_, begun.at("id").as_int64()).at("state"), "drawn") << "it may still begin";
  set("UPDATE trial SET created_ms = created_ms - 130000");
  EXPECT_EQ(Trial(ann_, begun.at("id").as_int64()).at("void"), "not_begun");
  // Its begin was not stored, and it ran to its end.
  set("UPDATE trial SET state = 'open', why = '', run = '', ended_ms = 1");
  EXPECT_EQ(Trial(ann_, begun.at("id").as_int64()).at("void"), "not_begun");
  const json::object second = Play(assignment);
  set("UPDATE trial SET state = 'running', ended_ms = 0 WHERE id = " + Id(second));
  set("UPDATE recording SET state = 'interrupted' WHERE id = '" + Text(second, "run") + "'");
  const json::object third = Play(assignment);
  EXPECT_EQ(Trial(ann_, second.at("id").as_int64()).at("void"), "interrupted");
  EXPECT_TRUE(Trial(ann_, second.at("id").as_int64()).at("truth").is_null());
  EXPECT_EQ(Trial(ann_, third.at("id").as_int64()).at("state"), "open");
  MakeDue(assignment);
  EXPECT_FALSE(Trial(ann_, second.at("id").as_int64()).at("truth").is_null());
  EXPECT_EQ(Call(ann_, "DELETE runs/" + Text(second, "run")).status, 204)
      << "nothing is kept from its owner for ever";
}

TEST_F(TrialTest, WhatIsDueIsOpenForWhoeverLooksAtItsRun) {
  const std::int64_t assignment = Assign(kRa, R"(,"attempts":3,"plan":{"duration_s":14})");
  std::vector<std::string> runs;
  for (int i = 0; i < 3; ++i) {
    const json::object trial = Play(assignment);
    EXPECT_EQ(Answer(ann_, trial.at("id").as_int64(), kRight).status, 200);
    runs.push_back(Text(trial, "run"));
  }
  EXPECT_EQ(ReasonOf(Call(ann_, "DELETE runs/" + runs[0])), "run_sealed");
  MakeDue(assignment);  // nobody looks at the trials themselves
  EXPECT_EQ(Call(ann_, "DELETE runs/" + runs[0]).status, 204);
  const std::string diagnose = R"({"runs":[{"diagnose":{"recording":")" + runs[1] + "\"}}]}";
  EXPECT_EQ(Call(ann_, "POST jobs", diagnose).status, 202);
  const auto ann = AccountOf("ann");
  ASSERT_TRUE(accounts_->EndEnrolment(course_, ann).ok());
  const json::object list = Ok(Call(ann_, "GET runs"));
  for (const json::value& run : list.at("items").as_array()) {
    EXPECT_FALSE(run.at("plan").as_object().contains("sealed")) << json::serialize(run);
  }
  EXPECT_EQ(Call(ann_, "DELETE runs/" + runs[2]).status, 204)
      << "her own, also when she has left the course";
}

TEST_F(PassingTrialTest, AClockThatIsSetAheadForAMomentReleasesNothing) {
  const std::int64_t assignment = Assign(kRa, R"(,"plan":{"duration_s":14})");
  const std::int64_t id = Play(assignment).at("id").as_int64();
  time_.SetAhead(std::chrono::hours(2));
  EXPECT_TRUE(Trial(ann_, id).at("truth").is_null());
  time_.SetAhead({});
  EXPECT_TRUE(Trial(ann_, id).at("truth").is_null());
  time_.Pass(std::chrono::minutes(61));
  EXPECT_FALSE(Trial(ann_, id).at("truth").is_null()) << "that hour has really passed";
}

TEST_F(PassingTrialTest, IsReleasedAndGradedAgainWhenNobodyLooks) {
  const std::int64_t assignment = Assign(kRa, kAtOnce);
  const std::int64_t id = Play(assignment).at("id").as_int64();
  Ok(Answer(ann_, id, R"({"component":"R1","value":56,"unit":"ohm","confidence":1})"));
  const std::string path = "assignments/" + std::to_string(assignment);
  const auto to_grade = [&] {
    return Ok(Call(mila_, "GET " + path)).at("progress").at("to_grade");
  };
  EXPECT_EQ(to_grade(), 0);
  Ok(Call(mila_,
          "PATCH " + path,
          R"({"rubric":{"detection":100,"isolation":0,"value":0,"confidence":0}})",
          IfMatch(1)));
  time_.Pass(std::chrono::seconds(61));
  EXPECT_TRUE(tests::Await([&] { return to_grade() == 0; }));
  EXPECT_EQ(Trial(ann_, id).at("points").to_number<double>(), 100.0);
}

TEST_F(TrialTest, ATeacherTriesItBeforeTheClassDoesAndIsInNoGradebook) {
  const std::int64_t assignment =
      Assign(kRa, kAtOnce + (R"(,"opens":")" + In(std::chrono::minutes(30)) + "\""));
  EXPECT_EQ(ReasonOf(TryStart(ann_, assignment)), "assignment_not_open");
  const json::object begun = Ok(TryStart(mila_, assignment), 201);
  EXPECT_TRUE(begun.at("truth").is_null());
  application_->runs().Wait(Text(begun, "run"));
  Ok(Answer(mila_, begun.at("id").as_int64(), kRight));
  const std::string path = "assignments/" + std::to_string(assignment);
  const json::object statistics = Ok(Call(mila_, "GET " + path + "/statistics"));
  EXPECT_EQ(statistics.at("students"), 0);
  const std::string csv = Call(mila_, "GET " + path + "/grades.csv").body;
  EXPECT_NE(csv.find("ann"), std::string::npos);
  EXPECT_EQ(csv.find("mila"), std::string::npos) << csv;
}

TEST_F(TrialTest, OneThatWasReleasedIsInNobodysWay) {
  const std::int64_t assignment = Assign(kRa, R"(,"attempts":2,"plan":{"duration_s":14})");
  const std::int64_t id = Play(assignment).at("id").as_int64();
  MakeDue(assignment);
  EXPECT_FALSE(Trial(ann_, id).at("truth").is_null());
  MakeDue(assignment, std::to_string(ToMilliseconds(Now() + std::chrono::hours(1))));
  EXPECT_EQ(ReasonOf(Answer(ann_, id, kRight)), "answer_late") << "she has seen the truth";
  EXPECT_EQ(TryStart(ann_, assignment).status, 201);
}

TEST_F(TrialTest, WhoeverElseStopsTheRunGivesTheAttemptBackAndIsInTheLog) {
  PlayAtSpeed(4.0);
  const std::int64_t assignment = Assign(kRa, R"(,"attempts":1,"plan":{"duration_s":600})");
  const auto stopped_by = [&](const Person& who) {
    const json::object begun = Ok(TryStart(ann_, assignment), 201);
    const std::string run = Text(begun, "run");
    EXPECT_EQ(Call(who, "POST runs/" + run + "/stop").status, 202);
    application_->runs().Wait(run);
    return Trial(ann_, begun.at("id").as_int64());
  };
  const json::object by_teacher = stopped_by(mila_);
  EXPECT_EQ(by_teacher.at("void"), "stopped_by_another");
  const json::object log = Ok(Call(Admin(), "GET audit?limit=100"));
  const std::string run = "run:" + Text(by_teacher, "run");
  EXPECT_TRUE(std::ranges::any_of(log.at("items").as_array(), [&](const json::value& line) {
    return line.at("actor_login") == "mila" && line.at("verb") == "stop_run" &&
           line.at("object").as_string() == run;
  })) << json::serialize(log);
  const json::object own = stopped_by(ann_);
  EXPECT_EQ(own.at("state"), "open") << "the attempt is used";
  EXPECT_EQ(ReasonOf(TryStart(ann_, assignment)), "trial_open");
  const std::int64_t id = own.at("id").as_int64();
  EXPECT_EQ(Answer(ann_, id, kRight).status, 200);
  MakeDue(assignment);
  const json::object graded = Trial(ann_, id);
  EXPECT_EQ(graded.at("grade").at("cut"), true) << "its fault never came";
  EXPECT_EQ(graded.at("points").to_number<double>(), 0.0);
}

TEST_F(TrialTest, ItsRunIsNotChangedDiagnosedReplayedOrDeleted) {
  const std::int64_t assignment = Assign(kRa, R"(,"plan":{"duration_s":14})");
  const std::string run(Play(assignment).at("run").as_string());
  EXPECT_EQ(ReasonOf(Call(ann_, "DELETE runs/" + run)), "run_sealed");
  EXPECT_EQ(ReasonOf(Call(ann_, "POST runs", R"({"recording":")" + run + "\"}")), "run_sealed");
  EXPECT_EQ(
      ReasonOf(Call(
          ann_, "POST jobs", R"({"name":"d","runs":[{"diagnose":{"recording":")" + run + "\"}}]}")),
      "run_sealed");
  const json::object diagnosis = Ok(Call(ann_, "GET runs/" + run + "/diagnosis"));
  EXPECT_EQ(diagnosis.at("verdict"), "calibrating");
  EXPECT_TRUE(diagnosis.at("candidates").as_array().empty());
}

TEST_F(TrialTest, WhereAllSimulatorsAreBusyPeopleGetThemInTheOrderInWhichTheyAsked) {
  PlayAtSpeed(4.0);
  const std::int64_t assignment = Assign(kRa, R"(,"attempts":1,"plan":{"duration_s":600})");
  const Person bob = Make("bob", Role::kStudent);
  const Person admin = Admin();
  std::vector<std::string> runs;
  for (const char* login : {"carl", "dora"}) {
    const Person other = Make(login, Role::kStudent);
    for (int each = 0; each < 2; ++each) {
      const json::object run = Ok(Call(other, "POST runs", R"({"duration_s":600})"), 201);
      runs.push_back(Id(run));
    }
  }
  const auto place_of = [](const tests::HttpAnswer& answer) {
    const json::object refused = Ok(answer, 503);
    EXPECT_EQ(refused.at("reason"), "in_line");
    const json::object& parameters = refused.at("parameters").as_object();
    EXPECT_LE(std::stoi(Text(parameters, "seconds")), 1200);
    return Text(parameters, "place");
  };
  const auto run_of = [&](const Person& who) {
    return Call(who, "POST runs", R"({"duration_s":14})");
  };
  EXPECT_EQ(place_of(TryStart(ann_, assignment)), "1");
  EXPECT_EQ(place_of(run_of(bob)), "2");
  EXPECT_EQ(place_of(TryStart(ann_, assignment)), "1") << "nothing was drawn for her";
  EXPECT_EQ(Call(mila_, "GET runs/" + runs[0]).status, 404);
  EXPECT_EQ(Call(admin, "POST runs/" + runs[0] + "/stop").status, 202);
  application_->runs().Wait(runs[0]);
  EXPECT_EQ(place_of(run_of(bob)), "2") << "the free one is hers";
  const json::object begun = Ok(TryStart(ann_, assignment), 201);
  EXPECT_EQ(place_of(run_of(bob)), "1");
  runs[0] = begun.at("run").as_string();
  for (const std::string& run : runs) {
    EXPECT_EQ(Call(admin, "POST runs/" + run + "/stop").status, 202);
    application_->runs().Wait(run);
  }
  EXPECT_EQ(run_of(bob).status, 201);
}

/// A bench of the lab, in the hands of the student.
class BenchTrialTest : public PassingTrialTest {
 protected:
  std::string TakeBench() {
    WaitForBenches(2);
    const json::object asked =
        Ok(Call(ann_, "POST tickets", R"({"rig_class":"bench","min_s":600})"), 201);
    const std::string accept = "tickets/" + Id(asked.at("ticket")) + "/accept";
    const json::object session = Ok(Call(ann_, "POST " + accept, "{}"));
    return Text(session, "rig");
  }
  tests::HttpAnswer TryStartOn(std::int64_t assignment, const std::string& rig) {
    return Call(ann_,
                "POST assignments/" + std::to_string(assignment) + "/trials",
                R"({"rig":")" + rig + "\"}");
  }
};

TEST_F(BenchTrialTest, IsPlayedInASessionAndItsTruthIsWhatTheRelaysSay) {
  constexpr const char* kRelays =
      R"({"healthy_share":0,"items":[{"component":"R1","values":[56],"onset_from_s":8}]})";
  const std::string on_bench = std::string(R"(,"on":"bench")") + kAtOnce;
  EXPECT_EQ(ReasonOf(TryAssignment(MakeSet(kRa), on_bench)), "pool_not_of_relays");
  EXPECT_EQ(ReasonOf(TryAssignment(
                MakeSet(R"({"items":[{"component":"R1","low":40,"high":60,"onset_from_s":8}]})"),
                on_bench)),
            "pool_not_of_relays");
  const std::int64_t assignment =
      Ok(TryAssignment(MakeSet(kRelays), on_bench), 201).at("id").as_int64();
  EXPECT_EQ(ReasonOf(TryStart(ann_, assignment)), "trial_needs_bench");
  EXPECT_EQ(ReasonOf(TryStartOn(assignment, "sim-1")), "trial_needs_bench");
  EXPECT_EQ(ReasonOf(TryStartOn(assignment, "bench-1")), "rig_needs_session");
  EXPECT_EQ(ReasonOf(TryStartOn(Assign(kRa, kAtOnce), "bench-1")), "trial_needs_simulator");
  const std::string rig = TakeBench();
  const json::object begun = Ok(TryStartOn(assignment, rig), 201);
  const std::string run = Text(begun, "run");
  const std::int64_t id = begun.at("id").as_int64();
  const json::object meanwhile = Ok(Call(ann_, "GET runs/" + run));
  EXPECT_EQ(meanwhile.at("rig").as_string(), rig);
  application_->runs().Wait(run);
  for (const char* target : {"rigs", "runs", "events"}) {
    const std::string told =
        tests::Request(application_->port(), "GET", "/api/v1/" + std::string(target), ann_.headers)
            .body;
    EXPECT_EQ(told.find("R1"), std::string::npos) << target << told;
  }
  const json::object answered =
      Ok(Answer(ann_, id, R"({"component":"R1","value":56,"unit":"ohm","confidence":1})"));
  EXPECT_EQ(answered.at("points").to_number<double>(), 100.0);
  const json::object opened = Ok(Call(ann_, "GET runs/" + run));
  bool confirmed = false;
  for (const json::value& event : opened.at("events").as_array()) {
    confirmed = confirmed || event.at("kind") == "relay_confirmed";
  }
  EXPECT_TRUE(confirmed);
}

TEST_F(BenchTrialTest, ASessionThatTheLabEndsGivesTheAttemptBack) {
  PlayAtSpeed(4.0);
  constexpr const char* kRelays =
      R"({"healthy_share":0,"items":[{"component":"R1","values":[56],"onset_from_s":8}]})";
  const std::int64_t assignment =
      Assign(kRelays, R"(,"on":"bench","attempts":2,"plan":{"duration_s":600})");
  const Person olga = Make("olga", Role::kOperator);
  const auto cut_by = [&](const Person& who) {
    const std::string rig = TakeBench();
    const json::object begun = Ok(TryStartOn(assignment, rig), 201);
    const std::string run = Text(begun, "run");
    EXPECT_TRUE(tests::Await(
        [&] { return Ok(Call(ann_, "GET runs/" + run)).at("samples").as_int64() > 0; }));
    const json::object sessions = Ok(Call(ann_, "GET sessions"));
    const std::string session = "sessions/" + Id(sessions.at("items").at(0)) + "/end";
    EXPECT_EQ(Call(who, "POST " + session, "{}").status, 204);
    application_->runs().Wait(run);
    return Trial(ann_, begun.at("id").as_int64());
  };
  EXPECT_EQ(cut_by(olga).at("void"), "session_ended");
  const json::object own = cut_by(ann_);
  EXPECT_TRUE(own.at("void").is_null());
  EXPECT_EQ(own.at("state"), "open") << "whoever does not like a fault cannot draw another one";
}

TEST_F(BenchTrialTest, WhoHandsTheSessionOverHasUsedTheAttempt) {
  PlayAtSpeed(4.0);
  const std::int64_t assignment =
      Assign(R"({"healthy_share":0,"items":[{"component":"R1","values":[56],"onset_from_s":8}]})",
             R"(,"on":"bench","attempts":2,"plan":{"duration_s":600})");
  const Person olga = Make("olga", Role::kOperator);
  const Person bob = Make("bob", Role::kStudent);
  const auto begun = [&] { return Ok(TryStartOn(assignment, TakeBench()), 201); };
  const auto session_path = [&](const Person& who) {
    const json::object sessions = Ok(Call(who, "GET sessions"));
    return "sessions/" + Id(sessions.at("items").at(0));
  };
  const json::object taken = begun();
  const std::string taken_from = session_path(ann_);
  EXPECT_EQ(Call(olga, "POST " + taken_from + "/take-over", R"({"reason":"the belt"})").status,
            200);
  application_->runs().Wait(Text(taken, "run"));
  EXPECT_EQ(Trial(ann_, taken.at("id").as_int64()).at("void"), "session_ended");
  EXPECT_EQ(Call(olga, "POST " + taken_from + "/end", "{}").status, 204);

  const json::object handed = begun();
  const std::string handed_over = session_path(ann_);
  EXPECT_LT(Call(ann_, "POST " + handed_over + "/handover", R"({"to":"bob"})").status, 300);
  EXPECT_LT(Call(bob, "POST " + handed_over + "/handover/accept", "{}").status, 300);
  application_->runs().Wait(Text(handed, "run"));
  const json::object used = Trial(ann_, handed.at("id").as_int64());
  EXPECT_TRUE(used.at("void").is_null()) << json::serialize(used);
  EXPECT_EQ(used.at("state"), "open");
}

TEST_F(BenchTrialTest, WhoLetsTheSessionRunOutHasUsedTheAttempt) {
  PlayAtSpeed(4.0);
  const std::int64_t assignment =
      Assign(R"({"healthy_share":0,"items":[{"component":"R1","values":[56],"onset_from_s":8}]})",
             R"(,"on":"bench","attempts":2,"plan":{"duration_s":600})");
  const Person root = Make("root", Role::kAdmin);
  json::object policy = Ok(Call(root, "GET policy"));
  policy.erase("version");
  policy["extended_max_s"] = 0;
  Ok(Call(root, "PUT policy", json::serialize(policy), IfMatch(0)));
  const json::object begun = Ok(TryStartOn(assignment, TakeBench()), 201);
  time_.Pass(std::chrono::hours(3));
  Ok(Call(ann_, "GET sessions"));
  application_->runs().Wait(Text(begun, "run"));
  const json::object used = Trial(ann_, begun.at("id").as_int64());
  EXPECT_TRUE(used.at("void").is_null()) << json::serialize(used);
  EXPECT_EQ(used.at("state"), "open");
}

}  // namespace
}  // namespace faultlab::server

// Courses: their members, class lists, invitations, and their teachers.
#include <gmock/gmock.h>
#include <soci/soci.h>

#include "server/auth/class_list_text.h"
#include "server/storage/rows.h"
#include "tests/server/auth/accounts_fixture.h"

namespace faultlab::server {
namespace {

using core::ErrorCode;
using std::chrono::hours;

class CoursesTest : public AccountsTest {
 protected:
  std::vector<std::int64_t> Ids(std::initializer_list<const char*> logins) {
    std::vector<std::int64_t> ids;
    for (const char* login : logins) ids.push_back(accounts_.GetByLogin(login).value().id);
    return ids;
  }
  /// Makes students "s.1", "s.2", .. by class lists of `maker`, without a course.
  void MakeStudents(std::int64_t count, std::int64_t maker) {
    const auto made = database_->Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
      tx.sql() << "INSERT INTO account (login, name, role, password_hash, disabled, created_ms, "
                  "version, made_by) WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM "
                  "n WHERE i < :count) SELECT 's.' || CAST(i AS TEXT), 'S', 'student', '', 0, 0, "
                  "1, CAST(:maker AS BIGINT) FROM n",
          soci::use(count, "count"), soci::use(maker, "maker");
      return core::Done{};
    });
    ASSERT_TRUE(made.ok()) << made.error().message;
  }
};

TEST_P(CoursesTest, APersonTeachesTwoHundredCoursesAndListsThemByPages) {
  const Account teacher = Person("teacher", Role::kInstructor);
  for (int i = 0; i < Accounts::kCoursesTaughtMax; ++i) {
    ASSERT_TRUE(accounts_.CreateCourse("c", teacher.id, kNow).ok());
  }
  EXPECT_EQ(accounts_.CreateCourse("c", teacher.id, kNow).error().reason, "courses_full");
  std::int64_t after = 0;
  for (const int expected : {150, 50, 0}) {
    const auto page = accounts_.ListCourses(teacher.id, false, after, 150).value();
    ASSERT_EQ(page.size(), static_cast<std::size_t>(expected));
    if (!page.empty()) after = page.back().id;
  }
  const std::int64_t old = accounts_.ListCourses(teacher.id, false, 0, 1).value()[0].id;
  ASSERT_TRUE(accounts_.EndEnrolment(old, teacher.id).ok());
  EXPECT_TRUE(accounts_.CreateCourse("c", teacher.id, kNow).ok());
}

TEST_P(CoursesTest, ACourseHasFiveThousandMembersAndInvitations) {
  const Account teacher = Person("teacher", Role::kInstructor);
  const std::int64_t course = accounts_.CreateCourse("c", teacher.id, kNow).value().id;
  MakeStudents(Accounts::kMembersMax - 1, 0);
  const auto filled = database_->Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    tx.sql() << "INSERT INTO enrolment (course_id, account_id, teaches, since_ms) SELECT "
                "CAST(:course AS BIGINT), id, 0, 0 FROM account WHERE login LIKE 's.%'",
        soci::use(course, "course");
    return core::Done{};
  });
  ASSERT_TRUE(filled.ok()) << filled.error().message;
  const auto refused = accounts_.EnrolCsv(As(teacher), course, "one.more,S\n", kNow);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().reason, "course_full");
  EXPECT_FALSE(accounts_.GetByLogin("one.more").ok()) << "nothing of a refused list stays";
}

TEST_P(CoursesTest, ClassListsOfATeacherMakeTenThousandAccounts) {
  const Account teacher = Person("teacher", Role::kInstructor);
  const Account other = Person("other", Role::kInstructor);
  const std::int64_t course = accounts_.CreateCourse("c", teacher.id, kNow).value().id;
  ASSERT_TRUE(accounts_.EnrolCsv(As(teacher), course, "s.0,S\n", kNow).ok());
  MakeStudents(Accounts::kAccountsMadeMax - 1, teacher.id);
  // A student who leaves the course makes no room for another account.
  const std::int64_t first = accounts_.GetByLogin("s.0").value().id;
  ASSERT_TRUE(accounts_.EndEnrolment(course, first).ok());
  const auto refused = accounts_.EnrolCsv(As(teacher), course, "one.more,S\n", kNow);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().reason, "accounts_full");
  EXPECT_FALSE(accounts_.GetByLogin("one.more").ok()) << "nothing of a refused list stays";
  EXPECT_TRUE(accounts_.EnrolCsv(As(teacher), course, "s.1,S\n", kNow).ok()) << "is invited";
  EXPECT_TRUE(accounts_.EnrolCsv(As(other), course, "one.more,S\n", kNow).ok());
}

TEST_P(CoursesTest, ACsvEnrolsAllOrNobodyAndNamesTheWrongLine) {
  const Account teacher = Person("teacher", Role::kInstructor);
  const Course course = accounts_.CreateCourse("Signals", teacher.id, kNow).value();
  const std::string csv =
      "\xEF\xBB\xBFlogin,name\r\nann,Ann Ångström\r\n\r\n\"bob\",\"山田 太郎\"\r\n";
  const Principal who = As(teacher);
  const Enrolment first = accounts_.EnrolCsv(who, course.id, csv, kNow).value();
  EXPECT_EQ(first.enrolled, Ids({"ann", "bob"}));
  const Enrolment again = accounts_.EnrolCsv(who, course.id, csv, kNow).value();
  EXPECT_EQ(again.members_already, 2) << "twice changes nothing";
  EXPECT_TRUE(again.enrolled.empty() && again.invited.empty());
  EXPECT_EQ(accounts_.Members(course.id).value().size(), 3u);
  EXPECT_EQ(accounts_.GetByLogin("bob").value().name, "山田 太郎");
  const auto wrong = accounts_.EnrolCsv(who, course.id, "cem,Cem\nno comma here\n", kNow);
  ASSERT_FALSE(wrong.ok());
  EXPECT_NE(wrong.error().message.find("Line 2"), std::string::npos);
  EXPECT_EQ(accounts_.GetByLogin("cem").error().code, ErrorCode::kNotFound);
  std::string million;
  for (int i = 0; i < 1'000'000; ++i) million += "u" + std::to_string(1000000 + i) + ",x\n";
  EXPECT_EQ(accounts_.EnrolCsv(who, course.id, million, kNow).error().code, ErrorCode::kTooLarge);
}

TEST_P(CoursesTest, ALookAtAListChangesNothing) {
  const Account teacher = Person("teacher", Role::kInstructor);
  Person("old", Role::kStudent);
  const Course course = accounts_.CreateCourse("Signals", teacher.id, kNow).value();
  const Principal who = As(teacher);
  ASSERT_TRUE(accounts_.EnrolCsv(who, course.id, "ann,Ann\n", kNow).ok());
  const Enrolment seen =
      accounts_.EnrolCsv(who, course.id, "ann,Ann\nnew1,New\nold,Old\n", kNow, true).value();
  std::vector<std::string> becomes;
  for (const Enrolment::Person& each : seen.people) {
    becomes.push_back(each.login + " " + std::string(each.becomes));
  }
  EXPECT_THAT(becomes, testing::ElementsAre("ann member", "new1 account", "old invited"));
  EXPECT_FALSE(accounts_.GetByLogin("new1").ok());
  EXPECT_EQ(accounts_.Members(course.id).value().size(), 2u);
  EXPECT_TRUE(accounts_.InvitationsTo(course.id).value().empty());
}

TEST_P(CoursesTest, AListIsTakenBackFromWhoeverHasNotUsedIt) {
  const Account teacher = Person("teacher", Role::kInstructor);
  const Account other = Person("other", Role::kInstructor);
  Person("old", Role::kStudent);
  const Course course = accounts_.CreateCourse("Signals", teacher.id, kNow).value();
  const Course second = accounts_.CreateCourse("Drives", other.id, kNow).value();
  const std::string csv = "ann,Ann\nbob,Bob\ncem,Cem\nold,Old\n";
  ASSERT_TRUE(accounts_.EnrolCsv(As(teacher), course.id, csv, kNow).ok());
  const std::string link =
      accounts_.CreateLink(accounts_.GetByLogin("bob").value().id, kNow).value();
  ASSERT_TRUE(accounts_.UseLink(link, "correct horse battery", kNow).ok());
  ASSERT_TRUE(accounts_.Enrol(second.id, accounts_.GetByLogin("cem").value().id, false).ok());

  const auto becomes = [&](const Account& who, WallTime now = kNow) {
    std::vector<std::string> all;
    const Enrolment undone = accounts_.TakeBackCsv(As(who), course.id, csv, now).value();
    for (const Enrolment::Person& each : undone.people) {
      all.push_back(each.login + " " + std::string(each.becomes));
    }
    return all;
  };
  EXPECT_THAT(becomes(other),
              testing::ElementsAre("ann stays", "bob stays", "cem stays", "old stays"))
      << "another teacher's list";
  EXPECT_THAT(becomes(Person("admin", Role::kAdmin)),
              testing::ElementsAre("ann stays", "bob stays", "cem stays", "old stays"))
      << "an admin takes back what an admin's list has done";
  const WallTime late =
      std::chrono::time_point_cast<WallTime::duration>(
          std::max(std::chrono::system_clock::time_point(kNow), std::chrono::system_clock::now())) +
      Accounts::kTakesBack + std::chrono::minutes(1);
  EXPECT_THAT(becomes(teacher, late),
              testing::ElementsAre("ann stays", "bob stays", "cem stays", "old stays"))
      << "within a day";
  EXPECT_THAT(becomes(teacher),
              testing::ElementsAre("ann gone", "bob stays", "cem left", "old left"));
  EXPECT_FALSE(accounts_.GetByLogin("ann").ok());
  EXPECT_TRUE(accounts_.GetByLogin("cem").ok()) << "is in another course";
  EXPECT_EQ(accounts_.Members(course.id).value().size(), 2u) << "teacher and bob";
  EXPECT_TRUE(accounts_.InvitationsTo(course.id).value().empty());
  EXPECT_THAT(becomes(teacher),
              testing::ElementsAre("ann stays", "bob stays", "cem stays", "old stays"))
      << "once";
}

TEST_P(CoursesTest, AddressesOfAListAreKeptForAccountsThatItMadeUntilTheyAreOpened) {
  const Account teacher = Person("teacher", Role::kInstructor);
  const Account other = Person("other", Role::kInstructor);
  Person("old", Role::kStudent);
  const Course course = accounts_.CreateCourse("Signals", teacher.id, kNow).value();
  const auto put = [&](const Account& who, const std::string& address) {
    const std::string csv = "login,name,e-mail\nann,Ann," + address + "\nold,Old,o@x\nc@x,Cem,\n";
    return accounts_.EnrolCsv(As(who), course.id, csv, kNow).value();
  };
  EXPECT_EQ(put(teacher, "ann@x").mail_from, "e-mail");
  const auto addresses = [&] {
    std::vector<std::string> all;
    const auto unopened = accounts_.ListUnopened(As(teacher), course.id, false).value();
    for (const auto& each : unopened) {
      all.push_back(each.account.login + " " + each.address);
    }
    return all;
  };
  EXPECT_THAT(addresses(), testing::ElementsAre("ann ann@x", "c@x c@x"));
  put(other, "thief@x");
  EXPECT_THAT(addresses(), testing::ElementsAre("ann ann@x", "c@x c@x")) << "of another teacher";
  put(teacher, "ann@y");
  EXPECT_THAT(addresses(), testing::ElementsAre("ann ann@y", "c@x c@x"));
  EXPECT_TRUE(accounts_.ListUnopened(As(other), course.id, false).value().empty());

  const std::int64_t ann = accounts_.GetByLogin("ann").value().id;
  const auto one = accounts_.CreateFurtherLink(ann, course.id, kNow).value();
  const auto two = accounts_.CreateFurtherLink(ann, course.id, kNow).value();
  EXPECT_EQ(two->address, "ann@y");
  EXPECT_TRUE(accounts_.OwnerOfLink(one->secret, kNow).ok()) << "that of an earlier mail works too";
  ASSERT_TRUE(accounts_.UseLink(two->secret, "correct horse battery", kNow).ok());
  EXPECT_FALSE(accounts_.OwnerOfLink(one->secret, kNow).ok());
  const core::Result<std::int64_t> kept =
      database_->Read([](Transaction& tx) -> core::Result<std::int64_t> {
        return CountRows(tx, "mail_choice WHERE address LIKE 'ann%'");
      });
  EXPECT_EQ(kept.value(), 0) << "her address was for the link alone";
  EXPECT_FALSE(accounts_.CreateFurtherLink(ann, course.id, kNow).value()) << "she can sign in";
  put(teacher, "evil@x");
  EXPECT_FALSE(
      accounts_.CreateFurtherLink(accounts_.GetByLogin("old").value().id, course.id, kNow).value());
  EXPECT_TRUE(accounts_.TakeBackCsv(As(teacher), course.id, "c@x,Cem\n", kNow).ok());
}

/// Who has a list can open accounts that it made and nobody has used, and no others.
TEST_P(CoursesTest, LinksAreForWhoeverCannotSignInYetAndForNobodyElse) {
  const Account teacher = Person("teacher", Role::kInstructor);
  const Account other = Person("other", Role::kInstructor);
  const Account old = Person("old", Role::kStudent);
  const Course course = accounts_.CreateCourse("Signals", teacher.id, kNow).value();
  ASSERT_TRUE(accounts_.EnrolCsv(As(teacher), course.id, "ann,Ann\nbob,Bob\n", kNow).ok());
  ASSERT_TRUE(accounts_.Enrol(course.id, old.id, false).ok());
  const auto of = [&](const Account& who) {
    const auto links = accounts_.CreateClassLinks(As(who), course.id, false, kNow).value();
    std::vector<std::string> logins;
    for (const auto& link : links) logins.push_back(link.account.login);
    return logins;
  };
  EXPECT_THAT(of(teacher), testing::ElementsAre("ann", "bob"));
  EXPECT_THAT(of(other), testing::IsEmpty()) << "the list was not theirs";
  const auto links = accounts_.CreateClassLinks(As(teacher), course.id, false, kNow).value();
  const std::string& secret = links.front().secret;
  EXPECT_EQ(accounts_.OwnerOfLink(secret, kNow).value().name, "Ann");
  EXPECT_EQ(accounts_.OwnerOfLink(secret, kNow).value().name, "Ann") << "nothing is used up";
  EXPECT_EQ(accounts_.OwnerOfLink("fll_x", kNow).error().reason, "link_over");
  const WallTime later = kNow + Accounts::kClassLinkLives - std::chrono::minutes(1);
  ASSERT_TRUE(accounts_.UseLink(secret, "correct horse battery", later).ok());
  EXPECT_EQ(accounts_.OwnerOfLink(secret, later).error().reason, "link_over");
  EXPECT_THAT(of(teacher), testing::ElementsAre("bob")) << "she can sign in now";
  EXPECT_EQ(accounts_.OwnerOfLink(links.back().secret, kNow).error().reason, "link_over")
      << "a newer one was made";
  // Whoever has become more than a student since is opened by no teacher.
  const auto last = accounts_.CreateClassLinks(As(teacher), course.id, false, kNow).value();
  ASSERT_EQ(last.size(), 1u);
  const Account& bob = last.front().account;
  ASSERT_TRUE(accounts_.Change(bob.id, bob.version, std::nullopt, Role::kOperator, {}).ok());
  EXPECT_EQ(accounts_.OwnerOfLink(last.front().secret, kNow).error().reason, "link_over");
  EXPECT_EQ(accounts_.UseLink(last.front().secret, "correct horse battery", kNow).error().reason,
            "link_over");
  ASSERT_TRUE(accounts_.EnrolCsv(As(teacher), course.id, "eva@uni.rs,Eva\n", kNow).ok());
  EXPECT_EQ(accounts_.CreateClassLinks(As(teacher), course.id, true, kNow).value().size(), 0u)
      << "a provider may vouch for her";
}

TEST_P(CoursesTest, NamesOfAClassListAreCleanAndTheirCommasStayInTheirField) {
  const Account teacher = Person("teacher", Role::kInstructor);
  const Course course = accounts_.CreateCourse("Signals", teacher.id, kNow).value();
  const auto enrol = [&](const std::string& line) {
    return accounts_.EnrolCsv(As(teacher), course.id, line, kNow);
  };
  ASSERT_TRUE(
      enrol("ann,=HYPERLINK(\"x\")\u202E\n\"bob\" , \"Lee, \"\"Bob\"\"\"\ncem,Lee, Cem\n").ok());
  EXPECT_EQ(accounts_.GetByLogin("ann").value().name, "HYPERLINK(\"x\")");
  EXPECT_EQ(accounts_.GetByLogin("bob").value().name, "Lee, \"Bob\"");
  EXPECT_EQ(accounts_.GetByLogin("cem").value().name, "Lee, Cem");
  EXPECT_EQ(enrol("\"evil9,x,admin\"").error().reason, "line_without_name");
  EXPECT_EQ(enrol("dan,\u200B").error().reason, "line_name_length");
  EXPECT_EQ(enrol("erased-7,Dan").error().reason, "line_login_wrong");
}

std::vector<std::string> ReadList(std::string_view text) {
  const auto lines = ParseClassList(text);
  if (!lines) return {lines.error().reason, lines.error().message.substr(0, 7)};
  std::vector<std::string> out;
  for (const ClassListLine& line : lines.value().lines) out.push_back(line.login + "=" + line.name);
  return out;
}

TEST(ClassListText, IsReadAsSpreadsheetsWriteIt) {
  using testing::ElementsAre;
  EXPECT_THAT(ReadList("ann;Jovanović, Ana\r\nbob;Bob\r\n"),
              ElementsAre("ann=Jovanović, Ana", "bob=Bob"));
  EXPECT_THAT(ReadList("ann,Lee; Ann\n"), ElementsAre("ann=Lee; Ann"));
  EXPECT_THAT(ReadList("ann\tAnn Lee\n"), ElementsAre("ann=Ann Lee"));
  EXPECT_THAT(ReadList("sep=;\r\nann;Ann, A.\r\n"), ElementsAre("ann=Ann, A."));
  EXPECT_THAT(ReadList("\"ann\";\"Lee; \"\"Ann\"\"\"\n"), ElementsAre("ann=Lee; \"Ann\""));
  EXPECT_THAT(ReadList("Index;Name;Mail;Login\n7;Ann Lee;a@b.rs;ann\n8;Bob;;bob\n"),
              ElementsAre("ann=Ann Lee", "bob=Bob"));
  EXPECT_THAT(ReadList("\xEF\xBB\xBFLogin,Name\nann,Ann\n"), ElementsAre("ann=Ann"));
}

TEST(ClassListText, IsReadAsLearningPlatformsAndDepartmentsWriteIt) {
  using testing::ElementsAre;
  const auto titles = [](std::string_view text) {
    const auto read = ParseClassList(text);
    return read ? read.value().login_from + " | " + read.value().name_from : read.error().reason;
  };
  const std::string_view moodle =
      "\"First name\",\"Last name\",\"ID number\",\"Email address\"\n"
      "Ana,Jovanović,301,ana@uni.rs\n";
  EXPECT_THAT(ReadList(moodle), ElementsAre("301=Ana Jovanović"));
  EXPECT_EQ(titles(moodle), "ID number | First name + Last name");
  EXPECT_THAT(ReadList("Nachname;Vorname;Benutzername\nGroß;Jörg;jgross\n"),
              ElementsAre("jgross=Jörg Groß"));
  EXPECT_THAT(ReadList("Apellidos,Nombre,Correo electrónico\nGarcía,Inés,ines@u.es\n"),
              ElementsAre("ines@u.es=Inés García"));
  EXPECT_THAT(ReadList("Korisnik;Ime i prezime\nana;Ana Jovanović\n"),
              ElementsAre("ana=Ana Jovanović"));
  EXPECT_THAT(ReadList("Broj indeksa;Ime i prezime\nRA 301/2026;Ana Jovanović\n;\n,;\n"),
              ElementsAre("ra-301-2026=Ana Jovanović"));
  EXPECT_THAT(ReadList("Student,ID,SIS Login ID,Section\nAnn Lee,12,alee,A\n"),
              ElementsAre("alee=Ann Lee"));
  EXPECT_THAT(ReadList("Neptun;Hallgató\nAB1CD2;Kiss Anna\nXY3ZW4;Nagy Béla\n"),
              ElementsAre("ab1cd2=Kiss Anna", "xy3zw4=Nagy Béla"))
      << "titles that nobody here has heard of";
  EXPECT_THAT(ReadList("ann,Ann Lee\nbob2,Bob Ray\n"), ElementsAre("ann=Ann Lee", "bob2=Bob Ray"));
  EXPECT_THAT(ReadList("user1,Student 1\nuser2,Student 2\n"),
              ElementsAre("user1=Student 1", "user2=Student 2"));
  EXPECT_THAT(ReadList("Name,Student No.\nAnn Smith,12345\n"), ElementsAre("12345=Ann Smith"));
  EXPECT_THAT(ReadList("Benutzername;Vor- und Zuname\njg7;Jörg Groß\n"),
              ElementsAre("jg7=Jörg Groß"));
  EXPECT_THAT(ReadList("Name;Vorname;Matrikelnummer\nGroß;Jörg;7788\n"),
              ElementsAre("7788=Jörg Groß"));
  EXPECT_THAT(ReadList("First name,Last name,ID number,Email address\nAnn,Lee,,ann@u.org\n"),
              ElementsAre("ann@u.org=Ann Lee"));
  EXPECT_THAT(ReadList("Student,SIS Login ID,Lab\n    Points Possible,,10\nAnn Lee,alee,\n"),
              ElementsAre("alee=Ann Lee"));
  EXPECT_THAT(ReadList("ann smith,Ann\n"), ElementsAre("line_login_wrong", "Line 1:"));
  EXPECT_EQ(titles("ann,Ann\nbob,Bob\n"), " | ");
}

TEST(ClassListText, TitlesAreKnownInManyLanguagesAndNeverAStudent) {
  using testing::ElementsAre;
  struct Titles {
    const char* first;
    const char* last;
    const char* number;
    const char* mail;
  };
  const std::vector<Titles> languages = {
      {"First name", "Surname", "Student number", "Email address"},
      {"VORNAME", "Familienname", "Matrikel-Nr.", "E-Mail-Adresse"},
      {"Prénom", "Nom", "Numéro étudiant", "Adresse e-mail"},
      {"Nombre", "Apellidos", "Matrícula", "Correo electrónico"},
      {"Nome", "Cognome", "Matricola", "E-mail"},
      {"Imię", "Nazwisko", "Nr indeksu", "Adres e-mail"},
      {"Ime", "Prezime", "Broj indeksa", "Imejl"},
      {"Име", "Презиме", "Број индекса", "Имејл"},
      {"Ad", "Soyad", "Öğrenci no", "E-posta"},
      {"Voornaam", "Achternaam", "Studentnummer", "Mail"},
      {"Etunimi", "Sukunimi", "Opiskelijanumero", "Email"}};
  for (const Titles& each : languages) {
    const std::string head = std::string(each.first) + ";" + each.last + ";";
    EXPECT_THAT(
        ReadList(head + each.number + ";" + each.mail +
                 "\r\nMila;Hill;20260011;mila@x.org\r\nJan;Vale;20260012;jan@x.org\r\n;;;\r\n"),
        ElementsAre("20260011=Mila Hill", "20260012=Jan Vale"))
        << head;
    EXPECT_THAT(ReadList(head + each.mail + "\rMila;Hill;mila@x.org\r"),
                ElementsAre("mila@x.org=Mila Hill"))
        << head << " of an old Mac";
  }
  // Titles that nobody knows, and none.
  const auto unclear = ParseClassList("Eesnimi;Perenimi;Kood\nMila;Hill;20260011\n");
  ASSERT_FALSE(unclear.ok());
  EXPECT_EQ(unclear.error().reason, "list_columns_unclear");
  EXPECT_NE(unclear.error().message.find("Eesnimi;Perenimi;Kood"), std::string::npos);
  EXPECT_THAT(ReadList("Mila;Hill;mila@x.org\nJan;Vale;jan@x.org\n").front(),
              "list_columns_unclear");
}

TEST(ClassListText, NamesTheLineThatIsWrong) {
  using testing::ElementsAre;
  EXPECT_THAT(ReadList("ann;Ann\nann;Anna\n"), ElementsAre("line_login_twice", "Line 2:"));
  EXPECT_THAT(ReadList("ann;Ann\nANN;Ann\nbob;Bob\n"), ElementsAre("ann=Ann", "bob=Bob"));
  EXPECT_THAT(ReadList("name;login\nAnn;ann\nBob\n"), ElementsAre("line_without_name", "Line 3:"));
  EXPECT_THAT(ReadList("\n\n"), ElementsAre("list_empty", "The lis"));
  EXPECT_THAT(ReadList("login;name\n"), ElementsAre("list_empty", "The lis"));
}

TEST_P(CoursesTest, AnAccountThatExistsJoinsACourseByItsOwnConsentOnly) {
  const Account teacher = Person("teacher", Role::kInstructor);
  const Account ann = Person("ann", Role::kStudent);
  const Account boss = Person("boss", Role::kAdmin);
  const Course course = accounts_.CreateCourse("Signals", teacher.id, kNow).value();
  const std::string csv = "ann,Ann\nboss,Boss\nnew,New\n";
  const Enrolment asked = accounts_.EnrolCsv(As(teacher), course.id, csv, kNow).value();
  EXPECT_EQ(asked.enrolled, Ids({"new"}));
  EXPECT_EQ(asked.invited, Ids({"ann", "boss"}));
  EXPECT_EQ(accounts_.Relation(As(teacher), ann.id).value(), Ownership::kForeign);
  EXPECT_FALSE(accounts_.Attends(ann.id, course.id).value());
  auto log = accounts_.ListAudit(0, 10).value();
  ASSERT_EQ(log.size(), 2u);
  EXPECT_EQ(log[0].verb + " " + log[0].detail, "invite ann, boss");
  EXPECT_EQ(log[1].verb + " " + log[1].detail, "enrol new");
  const Enrolment again = accounts_.EnrolCsv(As(teacher), course.id, csv, kNow).value();
  EXPECT_THAT(again.invited, testing::IsEmpty());
  EXPECT_EQ(again.invited_already, 2);
  EXPECT_EQ(again.members_already, 1);
  EXPECT_EQ(accounts_.ListAudit(0, 10).value().size(), 2u)
      << "the same list again says nothing new";

  const auto invitations = accounts_.InvitationsOf(ann.id).value();
  ASSERT_EQ(invitations.size(), 1u);
  EXPECT_EQ(invitations[0].course_name, "Signals");
  EXPECT_EQ(invitations[0].invited_by, teacher.name);
  EXPECT_EQ(accounts_.InvitationsTo(course.id).value().size(), 2u);

  ASSERT_TRUE(accounts_.AnswerInvitation(boss.id, course.id, /*accept=*/false).ok());
  EXPECT_EQ(accounts_.Relation(As(teacher), boss.id).value(), Ownership::kForeign);
  ASSERT_TRUE(accounts_.AnswerInvitation(ann.id, course.id, /*accept=*/true).ok());
  EXPECT_EQ(accounts_.Relation(As(teacher), ann.id).value(), Ownership::kCourse);
  EXPECT_TRUE(accounts_.InvitationsTo(course.id).value().empty());
  EXPECT_EQ(accounts_.AnswerInvitation(ann.id, course.id, true).error().code, ErrorCode::kNotFound);
}

TEST_P(CoursesTest, AnAdminEnrolsAccountsThatExist) {
  const Account teacher = Person("teacher", Role::kInstructor);
  const Account ann = Person("ann", Role::kStudent);
  const Account boss = Person("boss", Role::kAdmin);
  const Course course = accounts_.CreateCourse("Signals", teacher.id, kNow).value();
  ASSERT_TRUE(accounts_.EnrolCsv(As(teacher), course.id, "ann,Ann\n", kNow).ok());
  const Enrolment done = accounts_.EnrolCsv(As(boss), course.id, "ann,Ann\n", kNow).value();
  EXPECT_EQ(done.enrolled, Ids({"ann"}));
  EXPECT_TRUE(accounts_.Attends(ann.id, course.id).value());
  EXPECT_TRUE(accounts_.InvitationsOf(ann.id).value().empty());
}

TEST_P(CoursesTest, AnInstructorIsRelatedToTheStudentsOfOwnCoursesOnly) {
  const Account teacher = Person("teacher", Role::kInstructor);
  const Account other = Person("other", Role::kInstructor);
  const Account ann = Person("ann", Role::kStudent);
  const Course course = accounts_.CreateCourse("Signals", teacher.id, kNow).value();
  ASSERT_TRUE(accounts_.Enrol(course.id, ann.id, false).ok());
  const auto relation = [&](const Account& who) {
    Principal principal;
    principal.user_id = who.id;
    return accounts_.Relation(principal, ann.id).value();
  };
  EXPECT_EQ(relation(teacher), Ownership::kCourse);
  EXPECT_EQ(relation(other), Ownership::kForeign);
  EXPECT_EQ(relation(ann), Ownership::kOwn);
  EXPECT_TRUE(accounts_.Teaches(teacher.id, course.id).value());
  EXPECT_FALSE(accounts_.Teaches(ann.id, course.id).value());
  EXPECT_TRUE(accounts_.Attends(ann.id, course.id).value());
  EXPECT_EQ(accounts_.ListCourses(ann.id, false, 0, 50).value().size(), 1u);
  EXPECT_TRUE(accounts_.ListCourses(other.id, false, 0, 50).value().empty());
  EXPECT_EQ(accounts_.Enrol(999, ann.id, false).error().code, ErrorCode::kNotFound);
}

INSTANTIATE_TEST_SUITE_P(Engines, CoursesTest, tests::kBothEngines, tests::EngineName);

}  // namespace
}  // namespace faultlab::server

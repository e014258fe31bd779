// Accounts: courses and enrolment.
#include <algorithm>
#include <charconv>
#include <chrono>
#include <utility>

#include "server/auth/account_rows.h"
#include "server/auth/accounts.h"
#include "server/storage/turns.h"

namespace faultlab::server {
namespace {

using core::Done;
using core::Error;
using core::ErrorCode;
using soci::into;
using soci::use;

constexpr std::size_t kCsvLinesMax = 5000;

Error NoCourse() {
  return {ErrorCode::kNotFound, "there is no such course", ""};
}

bool CourseExists(Transaction& tx, std::int64_t id) {
  std::int64_t count = 0;
  tx.sql() << "SELECT COUNT(*) FROM course WHERE id = :id", into(count), use(id, "id");
  return count == 1;
}

void PutEnrolment(Transaction& tx, std::int64_t course, std::int64_t account, bool teaches) {
  const std::int64_t flag = teaches ? 1 : 0;
  // As the runs of its members are dated.
  const std::int64_t since_ms = ToMilliseconds(
      std::chrono::floor<std::chrono::milliseconds>(std::chrono::system_clock::now()));
  tx.sql() << "INSERT INTO enrolment (course_id, account_id, teaches, since_ms) "
              "VALUES (:course, :account, :teaches, :since) "
              "ON CONFLICT (course_id, account_id) DO NOTHING",
      use(course, "course"), use(account, "account"), use(flag, "teaches"), use(since_ms, "since");
}

bool IsMember(Transaction& tx, std::int64_t course, std::int64_t account) {
  std::int64_t count = 0;
  tx.sql() << "SELECT COUNT(*) FROM enrolment WHERE course_id = :course AND account_id = :account",
      into(count), use(course, "course"), use(account, "account");
  return count > 0;
}

/// @returns whether it is a new one.
bool PutInvitation(Transaction& tx,
                   std::int64_t course,
                   std::int64_t account,
                   std::int64_t teacher,
                   WallTime now) {
  const std::int64_t now_ms = ToMilliseconds(now);
  soci::statement put =
      (tx.sql().prepare
           << "INSERT INTO course_invitation (course_id, account_id, invited_by, created_ms) "
              "VALUES (:course, :account, :teacher, :now) "
              "ON CONFLICT (course_id, account_id) DO NOTHING",
       use(course, "course"),
       use(account, "account"),
       use(teacher, "teacher"),
       use(now_ms, "now"));
  put.execute(true);
  return put.get_affected_rows() > 0;
}

/// @returns whether there was one.
bool DropInvitation(Transaction& tx, std::int64_t course, std::int64_t account) {
  soci::statement drop =
      (tx.sql().prepare
           << "DELETE FROM course_invitation WHERE course_id = :course AND account_id = :account",
       use(course, "course"),
       use(account, "account"));
  drop.execute(true);
  return drop.get_affected_rows() == 1;
}

core::Result<std::vector<Invitation>> Invitations(Database& database,
                                                  const std::string& condition,
                                                  std::int64_t value) {
  using Found = std::vector<Invitation>;
  return database.Read([&](Transaction& tx) -> core::Result<Found> {
    Invitation row;
    std::int64_t at_ms = 0;
    soci::statement statement =
        (tx.sql().prepare << "SELECT c.id, c.name, a.login, t.name, i.created_ms "
                             "FROM course_invitation i JOIN course c ON c.id = i.course_id "
                             "JOIN account a ON a.id = i.account_id "
                             "JOIN account t ON t.id = i.invited_by WHERE " +
                                 condition + " ORDER BY c.id, a.login",
         into(row.course_id),
         into(row.course_name),
         into(row.login),
         into(row.invited_by),
         into(at_ms),
         use(value, "value"));
    statement.execute(false);
    Found out;
    while (statement.fetch()) {
      row.at = FromMilliseconds(at_ms);
      out.push_back(row);
    }
    return out;
  });
}

struct CsvLine {
  std::string login;
  std::string name;
};

std::optional<std::int64_t> AccountOf(Transaction& tx, const std::string& login) {
  std::int64_t id = 0;
  tx.sql() << "SELECT id FROM account WHERE login = :login", into(id), use(login, "login");
  if (!tx.sql().got_data()) return std::nullopt;
  return id;
}

/// `maker`: 0 when an admin makes it.
std::int64_t AddStudent(Transaction& tx, const CsvLine& line, std::int64_t maker, WallTime now) {
  const std::int64_t now_ms = ToMilliseconds(now);
  tx.sql() << "INSERT INTO account (login, name, role, password_hash, disabled, created_ms, "
              "version, made_by) VALUES (:login, :name, 'student', '', 0, :now, 1, :maker)",
      use(line.login, "login"), use(line.name, "name"), use(now_ms, "now"), use(maker, "maker");
  return AccountOf(tx, line.login).value();
}

std::string_view Trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t' || text.back() == '\r')) {
    text.remove_suffix(1);
  }
  return text;
}

std::string_view Field(std::string_view text) {
  text = Trimmed(text);
  const bool quoted = text.size() >= 2 && text.front() == '"' && text.back() == '"';
  return quoted ? text.substr(1, text.size() - 2) : text;
}

core::Result<std::vector<CsvLine>> ParseCsv(std::string_view csv) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (csv.starts_with(kByteOrderMark)) csv.remove_prefix(kByteOrderMark.size());
  std::vector<CsvLine> lines;
  std::size_t number = 0;
  while (!csv.empty()) {
    const std::size_t end = std::min(csv.find('\n'), csv.size());
    const std::string_view line = Trimmed(csv.substr(0, end));
    csv.remove_prefix(std::min(end + 1, csv.size()));
    ++number;
    const auto refuse = [&](const std::string& what) {
      return Error{ErrorCode::kInvalid, "line " + std::to_string(number) + ": " + what, ""};
    };
    if (line.empty()) continue;
    const std::size_t comma = line.find(',');
    if (comma == std::string_view::npos) return refuse("expected login,name");
    const std::string_view login = Field(line.substr(0, comma));
    const std::string_view name = Field(line.substr(comma + 1));
    if (number == 1 && login == "login") continue;
    const auto normal = NormalLogin(login);
    if (!normal.ok()) return refuse(normal.error().message);
    if (name.empty() || name.size() > 200) return refuse("a name has 1 to 200 bytes");
    if (lines.size() == kCsvLinesMax) {
      return Error{ErrorCode::kTooLarge, "5000 lines at most; split the file", ""};
    }
    lines.push_back({normal.value(), std::string(name)});
  }
  if (lines.empty()) return Error{ErrorCode::kInvalid, "no line holds login,name", ""};
  return lines;
}

core::Status CheckCourses(Transaction& tx, std::int64_t teacher) {
  std::int64_t taught = 0;
  tx.sql() << "SELECT COUNT(*) FROM enrolment WHERE account_id = :teacher AND teaches = 1",
      into(taught), use(teacher, "teacher");
  if (taught < Accounts::kCoursesTaughtMax) return Done{};
  const std::string most = std::to_string(Accounts::kCoursesTaughtMax);
  return Error{ErrorCode::kConflict,
               "you teach " + most +
                   " courses, as many as one person may; ask an admin to take you out of old ones",
               "",
               "courses_full",
               {{"most", most}}};
}

/// Entries that name every login; a long list takes several.
void PutAuditLines(Transaction& tx,
                   const Principal& who,
                   const std::string& verb,
                   std::int64_t course,
                   const std::vector<std::string>& logins,
                   WallTime now) {
  constexpr std::size_t kDetailBytes = 1000;
  const std::string object = "course:" + std::to_string(course);
  std::string detail;
  for (std::size_t i = 0; i < logins.size(); ++i) {
    detail += (detail.empty() ? "" : ", ") + logins[i];
    if (detail.size() < kDetailBytes && i + 1 < logins.size()) continue;
    account_rows::PutAuditLine(tx, who.owner_key(), verb, object, std::exchange(detail, {}), now);
  }
}

core::Status CheckMembers(Transaction& tx, std::int64_t course) {
  std::int64_t count = 0;
  tx.sql() << "SELECT (SELECT COUNT(*) FROM enrolment WHERE course_id = :course) + "
              "(SELECT COUNT(*) FROM course_invitation WHERE course_id = :same)",
      into(count), use(course, "course"), use(course, "same");
  if (count <= Accounts::kMembersMax) return Done{};
  const std::string most = std::to_string(Accounts::kMembersMax);
  return Error{ErrorCode::kConflict,
               "a course has at most " + most +
                   " members and invitations; make another course for the others",
               "",
               "course_full",
               {{"most", most}}};
}

core::Status CheckAccountsMade(Transaction& tx, std::int64_t maker) {
  std::int64_t count = 0;
  tx.sql() << "SELECT COUNT(*) FROM account WHERE made_by = :maker", into(count),
      use(maker, "maker");
  if (count <= Accounts::kAccountsMadeMax) return Done{};
  const std::string most = std::to_string(Accounts::kAccountsMadeMax);
  return Error{ErrorCode::kConflict,
               "one teacher's class lists make at most " + most +
                   " accounts; ask an admin to erase those of earlier years",
               "",
               "accounts_full",
               {{"most", most}}};
}

core::Result<bool> Enrolled(Database& database,
                            std::int64_t account,
                            std::int64_t course,
                            std::int64_t teaches) {
  return database.Read([&](Transaction& tx) -> core::Result<bool> {
    std::int64_t count = 0;
    tx.sql() << "SELECT COUNT(*) FROM enrolment WHERE account_id = :account "
                "AND course_id = :course AND teaches >= :teaches",
        into(count), use(account, "account"), use(course, "course"), use(teaches, "teaches");
    return count > 0;
  });
}

}  // namespace

core::Result<Course> Accounts::CreateCourse(const std::string& name,
                                            std::int64_t teacher,
                                            WallTime now) {
  if (name.empty() || name.size() > 200) {
    return Error{ErrorCode::kInvalid, "a name has 1 to 200 bytes", "name"};
  }
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Result<Course> {
    Course course;
    course.name = name;
    course.teaches = true;
    course.members = 1;
    const std::int64_t now_ms = ToMilliseconds(now);
    TakeTurn(tx, "courses of " + std::to_string(teacher));
    if (const auto room = CheckCourses(tx, teacher); !room.ok()) return room.error();
    // The newest id may be another server's course.
    tx.sql() << "INSERT INTO course (name, created_ms) VALUES (:name, :now) RETURNING id",
        into(course.id), use(name, "name"), use(now_ms, "now");
    PutEnrolment(tx, course.id, teacher, /*teaches=*/true);
    return course;
  });
}

core::Result<std::vector<Course>> Accounts::ListCourses(std::int64_t account_id,
                                                        bool all,
                                                        std::int64_t after,
                                                        int limit) {
  using Courses = std::vector<Course>;
  return database_.Read([&](Transaction& tx) -> core::Result<Courses> {
    Course course;
    std::int64_t teaches = 0;
    std::int64_t ends_ms = 0;
    soci::statement statement =
        (tx.sql().prepare << std::string("SELECT c.id, c.name, c.ends_ms, "
                                         "COALESCE(mine.teaches, 0), (SELECT COUNT(*) FROM "
                                         "enrolment e WHERE e.course_id = c.id) FROM course c ") +
                                 (all ? "LEFT " : "") +
                                 "JOIN enrolment mine ON mine.course_id = c.id AND "
                                 "mine.account_id = :account WHERE c.id > :after "
                                 "ORDER BY c.id LIMIT :count",
         into(course.id),
         into(course.name),
         into(ends_ms),
         into(teaches),
         into(course.members),
         use(account_id, "account"),
         use(after, "after"),
         use(limit, "count"));
    statement.execute(false);
    Courses out;
    while (statement.fetch()) {
      course.teaches = teaches != 0;
      course.ends.reset();
      if (ends_ms != 0) course.ends = FromMilliseconds(ends_ms);
      out.push_back(course);
    }
    return out;
  });
}

core::Status Accounts::SetCourseEnd(std::int64_t course_id, std::optional<WallTime> ends) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    if (!CourseExists(tx, course_id)) return NoCourse();
    const std::int64_t ends_ms = ends ? ToMilliseconds(*ends) : 0;
    tx.sql() << "UPDATE course SET ends_ms = :ends WHERE id = :id", use(ends_ms, "ends"),
        use(course_id, "id");
    return Done{};
  });
}

core::Status Accounts::Enrol(std::int64_t course_id, std::int64_t account_id, bool teaches) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    if (!CourseExists(tx, course_id)) return NoCourse();
    if (!account_rows::Find(tx, "id = :value", account_id)) return account_rows::NoAccount();
    PutEnrolment(tx, course_id, account_id, teaches);
    return Done{};
  });
}

core::Status Accounts::EndEnrolment(std::int64_t course_id, std::int64_t account_id) {
  const auto ended = database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    soci::statement removal =
        (tx.sql().prepare
             << "DELETE FROM enrolment WHERE course_id = :course AND account_id = :account",
         use(course_id, "course"),
         use(account_id, "account"));
    removal.execute(true);
    if (removal.get_affected_rows() != 1) {
      return Error{ErrorCode::kNotFound, "this account is not a member of the course", ""};
    }
    return Done{};
  });
  if (ended.ok()) {
    Tell({.what = Revocation::What::kCourse, .account_id = account_id, .course_id = course_id});
  }
  return ended;
}

core::Result<std::vector<Account>> Accounts::Members(std::int64_t course_id) {
  using Found = std::vector<Account>;
  return database_.Read([&](Transaction& tx) -> core::Result<Found> {
    if (!CourseExists(tx, course_id)) return NoCourse();
    account_rows::Row row;
    soci::statement statement =
        (tx.sql().prepare << "SELECT a.id, login, name, role, password_hash, disabled, created_ms, "
                             "version FROM account a JOIN enrolment e ON e.account_id = a.id "
                             "WHERE e.course_id = :course ORDER BY a.login",
         into(row.account.id),
         into(row.account.login),
         into(row.account.name),
         into(row.role),
         into(row.password_hash),
         into(row.disabled),
         into(row.created_ms),
         into(row.account.version),
         use(course_id, "course"));
    statement.execute(false);
    Found out;
    while (statement.fetch()) out.push_back(row.ToAccount());
    return out;
  });
}

core::Result<Enrolment> Accounts::EnrolCsv(const Principal& who,
                                           std::int64_t course_id,
                                           std::string_view csv,
                                           WallTime now) {
  const auto lines = ParseCsv(csv);
  if (!lines.ok()) return lines.error();
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Result<Enrolment> {
    if (!CourseExists(tx, course_id)) return NoCourse();
    TakeTurn(tx, "members of " + std::to_string(course_id));
    const std::int64_t maker = who.role == Role::kAdmin ? 0 : who.user_id;
    if (maker != 0) TakeTurn(tx, "accounts made by " + std::to_string(maker));
    Enrolment out;
    for (const CsvLine& line : lines.value()) {
      std::optional<std::int64_t> known = AccountOf(tx, line.login);
      if (known && IsMember(tx, course_id, *known)) {
        ++out.members_already;
      } else if (known && who.role != Role::kAdmin) {
        if (PutInvitation(tx, course_id, *known, who.user_id, now)) {
          out.invited.push_back(line.login);
        } else {
          ++out.invited_already;
        }
      } else {
        if (!known) known = AddStudent(tx, line, maker, now);
        PutEnrolment(tx, course_id, *known, /*teaches=*/false);
        DropInvitation(tx, course_id, *known);
        out.enrolled.push_back(line.login);
      }
    }
    if (const auto room = CheckMembers(tx, course_id); !room.ok()) return room.error();
    if (maker != 0) {
      if (const auto room = CheckAccountsMade(tx, maker); !room.ok()) return room.error();
    }
    PutAuditLines(tx, who, "enrol", course_id, out.enrolled, now);
    PutAuditLines(tx, who, "invite", course_id, out.invited, now);
    return out;
  });
}

core::Result<std::vector<Invitation>> Accounts::InvitationsOf(std::int64_t account_id) {
  return Invitations(database_, "i.account_id = :value", account_id);
}

core::Result<std::vector<Invitation>> Accounts::InvitationsTo(std::int64_t course_id) {
  return Invitations(database_, "i.course_id = :value", course_id);
}

core::Status Accounts::AnswerInvitation(std::int64_t account_id,
                                        std::int64_t course_id,
                                        bool accept) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    if (!DropInvitation(tx, course_id, account_id)) {
      return Error{ErrorCode::kNotFound, "no invitation to this course waits for you", ""};
    }
    if (accept) PutEnrolment(tx, course_id, account_id, /*teaches=*/false);
    return Done{};
  });
}

core::Result<Ownership> Accounts::Relation(const Principal& who,
                                           std::int64_t account_id,
                                           std::optional<WallTime> made_at) {
  if (who.user_id == account_id) return Ownership::kOwn;
  const std::int64_t made_ms = made_at ? ToMilliseconds(*made_at) : INT64_MAX;
  return database_.Read([&](Transaction& tx) -> core::Result<Ownership> {
    std::int64_t common = 0;
    tx.sql() << "SELECT COUNT(*) FROM enrolment mine JOIN enrolment theirs "
                "ON mine.course_id = theirs.course_id WHERE mine.account_id = :me "
                "AND mine.teaches = 1 AND theirs.account_id = :they AND theirs.since_ms <= :made",
        into(common), use(who.user_id, "me"), use(account_id, "they"), use(made_ms, "made");
    return common > 0 ? Ownership::kCourse : Ownership::kForeign;
  });
}

core::Result<Ownership> Accounts::RelationTo(const Principal& who,
                                             std::string_view owner_key,
                                             std::optional<WallTime> made_at) {
  const Ownership whose = OwnershipOf(who, owner_key);
  constexpr std::string_view kUserKey = "user:";
  if (whose == Ownership::kOwn || !who.signed_in()) return whose;
  if (!owner_key.starts_with(kUserKey)) return whose;
  const std::string_view text = owner_key.substr(kUserKey.size());
  std::int64_t id = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), id);
  if (error != std::errc() || end != text.data() + text.size()) return whose;
  return Relation(who, id, made_at);
}

core::Result<bool> Accounts::Teaches(std::int64_t account_id, std::int64_t course_id) {
  return Enrolled(database_, account_id, course_id, 1);
}

core::Result<bool> Accounts::Attends(std::int64_t account_id, std::int64_t course_id) {
  return Enrolled(database_, account_id, course_id, 0);
}

}  // namespace faultlab::server

#include "server/mail/class_mail.h"

#include <boost/json.hpp>
#include <charconv>
#include <chrono>
#include <optional>
#include <utility>

#include "server/notify/outbox.h"
#include "server/storage/rows.h"

namespace faultlab::server::mail {
namespace {

namespace json = boost::json;
using notify::Attempt;
using Outcome = Attempt::Outcome;

/// Of a course: "class_link:7".
std::string KindOf(std::int64_t course) {
  return "class_link:" + std::to_string(course);
}

std::optional<std::int64_t> CourseOf(std::string_view kind) {
  constexpr std::string_view kPrefix = "class_link:";
  if (!kind.starts_with(kPrefix)) return std::nullopt;
  std::int64_t course = 0;
  const char* const end = kind.data() + kind.size();
  const auto read = std::from_chars(kind.data() + kPrefix.size(), end, course);
  return read.ptr == end ? std::optional(course) : std::nullopt;
}

std::string DayOf(WallTime time) {
  return notify::Stamp(time).substr(0, 10);
}

Letter LetterOf(const json::value& about,
                const Account& account,
                const std::string& link,
                const std::string& until) {
  const std::string course(about.at("course").as_string());
  const std::string teacher(about.at("teacher").as_string());
  Letter letter;
  if (about.at("serbian").as_bool()) {
    letter.subject = "Vaš nalog u laboratoriji: " + course;
    letter.text = "Zdravo " + account.name + ",\n\n" + teacher + " vas je upisao/la na kurs „" +
                  course + "“.\nVaše korisničko ime je " + account.login +
                  ".\nOtvorite ovu vezu i izaberite lozinku; važi do " + until + ":\n\n" + link +
                  "\n";
  } else {
    letter.subject = "Your account in the laboratory: " + course;
    letter.text = "Hello " + account.name + ",\n\n" + teacher + " has put you on the list of \"" +
                  course + "\".\nYour login is " + account.login +
                  ".\nOpen this link and choose a password; it is good until " + until + ":\n\n" +
                  link + "\n";
  }
  return letter;
}

}  // namespace

ClassMail::ClassMail(Database& database,
                     Accounts& accounts,
                     MailSettings settings,
                     std::string base_url,
                     const Clock& clock)
    : database_(database),
      accounts_(accounts),
      settings_(std::move(settings)),
      client_(settings_),
      base_url_(std::move(base_url)),
      clock_(clock) {}

core::Result<ClassMail::Queued> ClassMail::Queue(const Principal& who,
                                                 std::int64_t course,
                                                 const std::string& course_name,
                                                 bool but_addresses,
                                                 bool serbian,
                                                 WallTime now) {
  if (settings_.smtp.empty()) return core::Refuse("no_mail");
  TRY(const auto all, accounts_.ListUnopened(who, course, but_addresses));
  const std::string about = json::serialize(
      json::object{{"course", course_name}, {"teacher", who.name}, {"serbian", serbian}});
  const std::string channel(notify::kMailChannel);
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Result<Queued> {
    Queued out;
    for (const Accounts::ClassLink& each : all) {
      if (!IsAddress(each.address)) {
        out.without.push_back(each.account.login);
        continue;
      }
      const bool waits =
          CountRows(tx,
                    "outbox WHERE channel = :channel AND kind = :kind AND "
                    "account_id = :id AND state = 'waiting'",
                    {{"channel", channel}, {"kind", KindOf(course)}, {"id", each.account.id}}) > 0;
      if (waits) continue;
      notify::outbox::Add(tx, channel, each.account.id, KindOf(course), about, now);
      ++out.count;
    }
    return out;
  });
}

core::Result<std::vector<ClassMail::Sent>> ClassMail::SentTo(std::int64_t course) {
  return database_.Read([&](Transaction& tx) {
    std::vector<Sent> list;
    for (auto& [login, at, state, attempts, error] :
         SelectTuples<std::string, WallTime, std::string, std::int64_t, std::string>(
             tx,
             "SELECT a.login, o.created_ms, o.state, o.attempts, o.error FROM outbox o JOIN "
             "account a ON a.id = o.account_id WHERE o.id IN (SELECT MAX(id) FROM outbox WHERE "
             "channel = :channel AND kind = :kind GROUP BY account_id) ORDER BY o.id DESC",
             {{"channel", std::string(notify::kMailChannel)}, {"kind", KindOf(course)}})) {
      list.push_back({std::move(login), at, std::move(state), attempts, std::move(error)});
    }
    return list;
  });
}

Attempt ClassMail::Send(const notify::Message& message) {
  const WallTime now = clock_.Wall();
  const auto course = CourseOf(message.kind);
  if (!course) return {Outcome::kNever, "nothing mails " + message.kind};
  const auto link = accounts_.CreateFurtherLink(message.account, *course, now);
  if (!link) return {Outcome::kNotNow, link.error().message};
  if (!link.value()) return {Outcome::kNever, "can sign in by now, or has left the course"};
  if (!IsAddress(link.value()->address)) return {Outcome::kNever, "no address is known"};
  Letter letter = LetterOf(json::parse(message.about),
                           link.value()->account,
                           base_url_ + "/reset?token=" + link.value()->secret,
                           DayOf(now + Accounts::kClassLinkLives));
  letter.to = link.value()->address;
  letter.to_name = link.value()->account.name;
  letter.id = message.delivery;
  letter.date = now;
  Attempt attempt = client_.Send(letter);
  constexpr std::int64_t kAttemptsMax = 8;  // some 8 minutes
  const bool again = attempt.outcome == Outcome::kRefused && message.attempts < kAttemptsMax;
  if (attempt.outcome == Outcome::kRefused && !again) attempt.outcome = Outcome::kNever;
  attempt.pause = std::chrono::milliseconds(std::chrono::minutes(1)) / settings_.per_minute;
  return attempt;
}

}  // namespace faultlab::server::mail

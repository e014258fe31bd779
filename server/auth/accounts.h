#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/types/result.h"
#include "server/auth/authenticator.h"
#include "server/auth/authorization.h"
#include "server/auth/cookies.h"
#include "server/auth/revocation.h"
#include "server/auth/secrets.h"
#include "server/auth/sign_in_limits.h"
#include "server/auth/throttle.h"
#include "server/auth/vouched_person.h"
#include "server/storage/database.h"
#include "server/wall_time.h"

namespace faultlab::server {

struct Account {
  std::int64_t id = 0;
  std::string login;  ///< lower case, unique
  std::string name;   ///< any script
  Role role = Role::kStudent;
  bool disabled = false;
  bool has_password = false;
  std::int64_t version = 1;
  WallTime created_at{};
};

/// The account as a caller, without a proof.
Principal PrincipalOf(const Account& account);

struct ApiKey {
  std::int64_t id = 0;
  std::int64_t account_id = 0;
  std::string name;
  std::set<std::string> scopes;
  WallTime created_at{};
  WallTime expires_at{};
  bool revoked = false;
};

struct Course {
  std::int64_t id = 0;
  std::string name;
  bool teaches = false;  ///< the requesting account teaches it
  int members = 0;
  std::optional<WallTime>
      ends{};  ///< last day; recordings of its students are kept at least until then
};

/// The outcome for the logins of a class list.
struct Enrolment {
  std::vector<std::int64_t> enrolled;  ///< accounts that are members now
  std::vector<std::int64_t> invited;   ///< that are members when they accept
  int invited_already = 0;             ///< invited before, without an answer yet
  int members_already = 0;
  int refused = 0;  ///< of a roster: disabled, no student here, or no login is left for them

  /// What becomes of one line.
  struct Person {
    std::string login;
    std::string name;
    /// "account": it is made, "enrolled", "invited", "member": is one. Of a list that is taken
    /// back: "gone": so is the account, "left": the course, "stays".
    std::string_view becomes;
  };
  std::vector<Person> people;  ///< in the order of the list
  std::string login_from;      ///< as ClassListText
  std::string name_from;
  std::string mail_from;
};

/// An invitation of an account to a course.
struct Invitation {
  std::int64_t course_id = 0;
  std::string course_name;
  std::string login;       ///< the invited account
  std::string invited_by;  ///< name of the teacher
  WallTime at{};
};

struct AuditEntry {
  std::int64_t seq = 0;
  WallTime at{};
  std::string actor;        ///< Principal::owner_key(), "system"
  std::string actor_login;  ///< of an actor with an account, as it is today; otherwise empty
  std::string verb;
  std::string object;
  std::string object_login;  ///< of the object, an account or a run of one
  std::string object_name;   ///< of a course, fault set or key that exists; of a session its rig
  std::string detail;        ///< accounts by their logins of today
};

/// Which accounts a list has; what is absent does not restrict it.
struct AccountFilter {
  std::string text{};  ///< part of login (often a mail address) or name, in any case
  std::optional<Role> role{};
  std::optional<std::int64_t> course{};  ///< members, teachers included
};

/// Which lines of the audit log a list has; what is absent does not restrict it.
struct AuditFilter {
  std::string text{};                ///< part of verb, object, detail or of a login
  std::vector<std::string> verbs{};  ///< lines with one of these are taken besides those of `text`
  std::string who{};                 ///< part of the login (or key) of who did it
  std::optional<WallTime> from{};
  std::optional<WallTime> to{};
};

struct SignInRequest {
  std::string login;
  std::string password;
  std::string address;  ///< of the client
  std::string device;   ///< value of the device cookie; empty if none came
};

/// The values of two cookies, of which only hashes are stored.
struct SignedIn {
  Principal principal;
  std::string cookie_secret;  ///< the sign-in
  std::string device_secret;  ///< the device (browser), for its next sign-in
};

/// A line for the audit log.
struct AuditNote {
  Principal who;
  std::string verb;
  std::string object;
  std::string detail;
};

struct SignInOutcome {
  core::Result<SignedIn> signed_in;
  std::optional<AuditNote> note{};  ///< none when the password was not checked
};

/// Where a request without credentials is accepted as a guest.
enum class GuestAccess { kNever, kLoopback, kEverywhere };

/// Accounts, sign-ins, API keys, links, courses, audit log. Thread-safe. SignIn, ChangePassword and
/// UseLink compute argon2id and block for 100 ms or more: on the pool only.
class Accounts {
 public:
  static constexpr int kLiveKeysMax = 100;   ///< of an account, neither revoked nor expired
  static constexpr int kPastKeysKept = 100;  ///< expired or revoked
  static constexpr int kKeysShownMax = kLiveKeysMax + kPastKeysKept;
  static constexpr int kCoursesTaughtMax = 200;    ///< by one person
  static constexpr int kMembersMax = 5000;         ///< of a course, invitations included
  static constexpr int kAccountsMadeMax = 10'000;  ///< by one teacher's class lists

  Accounts(Database& database,
           GuestAccess guests,
           PasswordCost password_cost = PasswordCost::kInteractive);

  /// Sets a function that is called by the thread that ended the rights, after the commit; it must
  /// not block for long. To be set before the first request. It is called only for changes by this
  /// process, not by `faultlab admin` or another server on the same database.
  void SetOnRevoked(std::function<void(const Revocation&)> on_revoked) {
    on_revoked_ = std::move(on_revoked);
  }

  /// Without credentials: the guest. Wrong, expired or revoked credentials: kUnauthorized, never
  /// the guest. A cookie on a state-changing request without the right CSRF token, or from a
  /// foreign Origin: kForbidden. May use the database but never hashes a password.
  core::Result<Principal> Authenticate(const RequestCredentials& credentials, WallTime now);
  /// Whether the sign-in or key of `who` is still valid, and for a sign-in the role unchanged.
  core::Result<bool> Holds(const Principal& who, WallTime now);

  /// Wrong login and wrong password give the same answer after the same time. Limited by
  /// SignInLimits (kTooMany).
  SignInOutcome SignIn(const SignInRequest& request, WallTime now);
  /// `request` has no login and password. An existing account is never found by its login or e-mail
  /// address, only by an identity added to it before, or as `rules` allow. Otherwise kForbidden
  /// with a reason.
  SignInOutcome SignInByIdentity(const VouchedPerson& person,
                                 const NewcomerRules& rules,
                                 const SignInRequest& request,
                                 WallTime now);
  /// The same without a sign-in.
  core::Result<Account> AdmitByIdentity(const VouchedPerson& person,
                                        const NewcomerRules& rules,
                                        WallTime now);
  /// Marks what somebody was given to use once. kForbidden, reason "oidc_elsewhere", the second
  /// time within an hour.
  core::Status UseOnce(const std::string& state, WallTime now);
  /// The owner of the account, signed in, has proved to be this person too.
  core::Status AddIdentity(std::int64_t account_id, const VouchedPerson& person, WallTime now);
  core::Result<std::vector<LinkedIdentity>> Identities(std::int64_t account_id);
  /// kConflict when it is the only way to sign in to the account.
  core::Status RemoveIdentity(std::int64_t account_id, const std::string& issuer);
  core::Status SignOut(const Principal& who);
  /// Ends every other sign-in of the account and removes its devices; with `also_keys` its API keys
  /// and its calendar link end too.
  core::Status ChangePassword(const Principal& who,
                              const std::string& old_password,
                              const std::string& new_password,
                              bool also_keys,
                              WallTime now);

  /// A student who cannot sign in yet: an account that a class list of this teacher has made (of
  /// any teacher, for an admin), without a password and without a provider's identity. A link sets
  /// its password only as long as that is so.
  struct ClassLink {
    Account account;
    std::string address;  ///< of mail: the class list's, or a login that is one; else empty
    std::string secret;   ///< as CreateLink, for kClassLinkLives; empty: no link was made
  };
  static constexpr auto kClassLinkLives = std::chrono::hours(14 * 24);
  /// Those of a course, without links, in order of the login.
  /// @param but_addresses  not those whose login is an address of mail: a provider may vouch for it
  core::Result<std::vector<ClassLink>> ListUnopened(const Principal& who,
                                                    std::int64_t course_id,
                                                    bool but_addresses);
  /// The same with a link each. Earlier links of theirs end.
  core::Result<std::vector<ClassLink>> CreateClassLinks(const Principal& who,
                                                        std::int64_t course_id,
                                                        bool but_addresses,
                                                        WallTime now);
  /// A link for one of them besides those that there are; none for who can sign in by now, or has
  /// left the course.
  core::Result<std::optional<ClassLink>> CreateFurtherLink(std::int64_t account_id,
                                                           std::int64_t course_id,
                                                           WallTime now);
  /// Whose account a link is for; it stays unused. Errors as UseLink.
  core::Result<Account> OwnerOfLink(const std::string& secret, WallTime now);
  /// A one-time secret (24 h) that sets the password of an account; the admin passes it on.
  core::Result<std::string> CreateLink(std::int64_t account_id, WallTime now);
  /// Sets the password and ends all other ways into the account. @returns the account's id.
  core::Result<std::int64_t> UseLink(const std::string& secret,
                                     const std::string& new_password,
                                     WallTime now);
  /// While no admin has a password: the account `admin` and a link for it. A link made by another
  /// server of the database, or by an admin at the command line, stays valid and is not replaced.
  struct FirstLink {
    std::string secret;   ///< empty: another one has made the link
    std::string made_by;  ///< that server; empty: `faultlab admin`
  };
  core::Result<std::optional<FirstLink>> FirstStartLink(const std::string& server, WallTime now);

  core::Result<Account> Create(const std::string& login,
                               const std::string& name,
                               Role role,
                               WallTime now);
  /// kStale when `version` is not the stored one. Disabling ends sign-ins, keys and links;
  /// disabling and a change of the role also close everything that is open.
  core::Result<Account> Change(std::int64_t id,
                               std::int64_t version,
                               const std::optional<std::string>& name,
                               std::optional<Role> role,
                               std::optional<bool> disabled);
  core::Result<Account> Get(std::int64_t id);
  core::Result<Account> GetByLogin(const std::string& login);
  /// In order of id, after `after`.
  core::Result<std::vector<Account>> List(const AccountFilter& filter,
                                          std::int64_t after,
                                          int limit);
  core::Result<std::vector<Account>> List(std::int64_t after, int limit) {
    return List({}, after, limit);
  }

  /// The key itself is returned only here. Scopes: kScopes; at most 400 days.
  struct NewKey {
    ApiKey key;
    std::string secret;
  };
  /// kConflict "keys_full" above kLiveKeysMax. Of expired and revoked keys, the newest are kept.
  core::Result<NewKey> CreateKey(const Principal& who,
                                 const std::string& name,
                                 const std::set<std::string>& scopes,
                                 WallTime expires_at,
                                 WallTime now);
  /// Valid keys, then the newest of the expired and revoked ones: at most kKeysShownMax.
  core::Result<std::vector<ApiKey>> ListKeys(std::int64_t account_id, WallTime now);
  core::Status RevokeKey(std::int64_t account_id, std::int64_t key_id, WallTime now);

  /// kConflict "courses_full" when `teacher` teaches kCoursesTaughtMax.
  core::Result<Course> CreateCourse(const std::string& name, std::int64_t teacher, WallTime now);
  core::Status SetCourseEnd(std::int64_t course_id, std::optional<WallTime> ends);
  /// In order of id, after `after`.
  core::Result<std::vector<Course>> ListCourses(std::int64_t account_id,
                                                bool all,
                                                std::int64_t after,
                                                int limit);
  /// nullopt: there is none.
  core::Result<std::optional<Course>> FindCourse(std::int64_t course_id);
  core::Status Enrol(std::int64_t course_id, std::int64_t account_id, bool teaches);
  /// kNotFound when the account is not a member.
  core::Status EndEnrolment(std::int64_t course_id, std::int64_t account_id);
  core::Result<std::vector<Account>> Members(std::int64_t course_id);
  /// login,name per line (header optional, any line end): missing students are created and
  /// enrolled. Existing accounts are invited, because a teacher reads the runs of the members; an
  /// admin enrols them at once. The audit log names all of them. A wrong line refuses the whole
  /// list; the Error names the line. At most 5 000 lines. kConflict "course_full" when members and
  /// invitations would exceed kMembersMax, "accounts_full" when `who` is not an admin and would
  /// have made more than kAccountsMadeMax.
  /// @param only_look  says what would become of each line and changes nothing
  core::Result<Enrolment> EnrolCsv(const Principal& who,
                                   std::int64_t course_id,
                                   std::string_view csv,
                                   WallTime now,
                                   bool only_look = false);
  /// The same of people whom a platform knows, with its bounds and its audit lines: who is new here
  /// joins, who has an account is invited.
  core::Result<Enrolment> EnrolRoster(const Principal& who,
                                      std::int64_t course_id,
                                      std::span<const RosterPerson> people,
                                      WallTime now);
  /// Takes back what such a list of `who` has done within kTakesBack: accounts that it made and
  /// nobody has used go (or leave the course, where they are in another one), and its invitations
  /// end. Whoever has a password or an identity stays, and who had an account before an admin's
  /// list.
  static constexpr auto kTakesBack = std::chrono::hours(24);
  core::Result<Enrolment> TakeBackCsv(const Principal& who,
                                      std::int64_t course_id,
                                      std::string_view csv,
                                      WallTime now);
  /// The unanswered invitations of an account, or of a course.
  core::Result<std::vector<Invitation>> InvitationsOf(std::int64_t account_id);
  core::Result<std::vector<Invitation>> InvitationsTo(std::int64_t course_id);
  /// Joins the course, or declines. kNotFound when the account is not invited.
  core::Status AnswerInvitation(std::int64_t account_id, std::int64_t course_id, bool accept);
  /// kOwn when `who` is the account, kCourse when `who` teaches a course of the account, otherwise
  /// kForeign.
  /// @param made_at  when their object was made: a teacher has access to objects made since they
  ///    joined
  core::Result<Ownership> Relation(const Principal& who,
                                   std::int64_t account_id,
                                   std::optional<WallTime> made_at = {});
  /// The same for an object, by its owner's key: "guest", "user:7".
  core::Result<Ownership> RelationTo(const Principal& who,
                                     std::string_view owner_key,
                                     std::optional<WallTime> made_at = {});
  core::Result<bool> Teaches(std::int64_t account_id, std::int64_t course_id);
  core::Result<bool> Attends(std::int64_t account_id, std::int64_t course_id);
  /// Those that the account attends or teaches, ascending.
  core::Result<std::vector<std::int64_t>> CoursesOf(std::int64_t account_id);
  /// kOwn: teaches the course; kCourse: attends it; kForeign: neither.
  core::Result<Ownership> InCourse(std::int64_t account_id, std::int64_t course_id);

  core::Status Audit(const std::string& actor,
                     const std::string& verb,
                     const std::string& object,
                     const std::string& detail,
                     WallTime now);
  /// Newest first, below `before` (0 = from the newest).
  core::Result<std::vector<AuditEntry>> ListAudit(const AuditFilter& filter,
                                                  std::int64_t before,
                                                  int limit);
  core::Result<std::vector<AuditEntry>> ListAudit(std::int64_t before, int limit) {
    return ListAudit({}, before, limit);
  }

 private:
  core::Result<Principal> BySession(std::string_view secret,
                                    const RequestCredentials& credentials,
                                    WallTime now);
  core::Result<Principal> ByKey(std::string_view secret, WallTime now);
  /// Opens a sign-in for a browser whose owner has been authenticated. `password_hash` is the hash
  /// that was checked: kUnauthorized when it is no longer the account's.
  core::Result<SignedIn> OpenSignIn(const Account& account,
                                    const std::optional<std::string>& password_hash,
                                    const std::string& address,
                                    const std::string& device,
                                    WallTime now);
  void Tell(const Revocation& revocation) const {
    if (on_revoked_) on_revoked_(revocation);
  }

  Database& database_;
  const GuestAccess guests_;
  PasswordHasher hasher_;
  SignInLimits limits_;
  Throttle old_passwords_{5};  ///< tries to change a password, by sign-in
  std::function<void(const Revocation&)> on_revoked_;
};

/// 3 to 64 of [a-z0-9._@-] after lowering, and not that of an erased account; kInvalid names the
/// field.
core::Result<std::string> NormalLogin(std::string_view login);
core::Status CheckPasswordRules(std::string_view password);

}  // namespace faultlab::server

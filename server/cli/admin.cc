#include "server/cli/admin.h"

#include <sys/stat.h>

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>

#include "server/auth/accounts.h"
#include "server/cli/console.h"
#include "server/run/run_messages.h"
#include "server/storage/database.h"
#include "server/storage/database_check.h"
#include "server/storage/owner_key.h"

namespace faultlab::server {
namespace {

namespace fs = std::filesystem;
using core::Error;
using core::ErrorCode;
using core::Result;
using core::Status;

WallTime Now() {
  return std::chrono::time_point_cast<std::chrono::milliseconds>(std::chrono::system_clock::now());
}

fs::path DatabaseFile(const AdminTarget& target) {
  return fs::path(target.data_dir) / "faultlab.db";
}

/// Runs `work` on the accounts and prints its text.
int WithAccounts(const AdminTarget& target,
                 const std::function<Result<std::string>(Accounts&)>& work) {
  const Result<std::unique_ptr<Database>> database = OpenExisting(target);
  if (!database) {
    return Fail(database.error());
  }
  Accounts accounts(*database.value(), GuestAccess::kNever);
  const Result<std::string> text = work(accounts);
  return text ? Print(text.value()) : Fail(text.error());
}

std::string Line(const Account& account) {
  return std::to_string(account.id) + "\t" + account.login + "\t" +
         std::string(Name(account.role)) + "\t" +
         (account.disabled       ? "disabled"
          : account.has_password ? "active"
                                 : "no password yet") +
         "\t" + account.name + "\n";
}

std::string LinkText(const std::string& login, const std::string& secret) {
  return "One-time link for " + login +
         ", good for 24 hours. Open it in a browser, with the address of your laboratory if that "
         "is "
         "another:\n  http://127.0.0.1:8080/reset?token=" +
         secret + "\n";
}

/// By a verb of kAuditVerbs. The change is done and stored; if it cannot be written to the audit
/// log, this is reported and not refused.
void Audit(Accounts& accounts,
           const std::string& verb,
           const Account& account,
           const std::string& detail) {
  const std::string object = OwnerKeyOf(account.id);
  const Status kept = accounts.Audit("system", verb, object, detail, Now());
  if (!kept) PrintError("done, but not in the audit log: " + kept.error().message);
}

int SetDisabled(const UserOptions& options, bool disabled) {
  return WithAccounts(options.target, [&](Accounts& accounts) -> Result<std::string> {
    TRY(const auto account, accounts.GetByLogin(options.login));
    TRY(const auto changed,
        accounts.Change(account.id, account.version, std::nullopt, std::nullopt, disabled));
    Audit(accounts, "change_user", changed, disabled ? "disabled" : "enabled");
    return Line(changed);
  });
}

/// A principal for the account itself: whoever can use the command line has the database file
/// anyway.
Principal Standing(const Account& account) {
  Principal principal = PrincipalOf(account);
  principal.proof = Proof::kSessionCookie;
  return principal;
}

/// A line for each recording.
Result<std::string> CutAllDamage(Database& database) {
  TRY(const auto damaged, FindDamagedRecordings(database));
  std::string text;
  RecordingStore store(database);
  for (const DamagedRecording& each : damaged) {
    TRY(const auto record, store.Get(each.id));
    TRY(const auto lost,
        CutDamage(database, each.id, [&](std::int64_t index, std::int64_t samples) {
          return MakeEvent({.kind = hardware::RigEventKind::kGap,
                            .index = index,
                            .value = static_cast<double>(samples),
                            .text = "damaged on the disk, taken out by an operator"},
                           record.period_s);
        }));
    text += each.id + ": " + std::to_string(lost) + " samples taken out\n";
  }
  return text;
}

}  // namespace

Result<std::unique_ptr<Database>> OpenExisting(const AdminTarget& target) {
  if (!target.database_url.empty()) {
    return Database::Open({.location = target.database_url, .existing = true});
  }
  const fs::path file = DatabaseFile(target);
  std::error_code ignored;
  if (!fs::exists(file, ignored)) {
    return Error{ErrorCode::kNotFound,
                 "there is no database at " + file.string() +
                     "; name its folder with --data, or start the server once",
                 "data"};
  }
  return Database::Open({.location = file.string(), .existing = true});
}

int RunUserList(const AdminTarget& target) {
  return WithAccounts(target, [](Accounts& accounts) -> Result<std::string> {
    constexpr int kPage = 200;
    std::string text;
    std::int64_t after = 0;
    for (;;) {
      TRY(const auto page, accounts.List(after, kPage));
      if (page.empty()) {
        return text;
      }
      for (const Account& account : page) {
        text += Line(account);
        after = account.id;
      }
    }
  });
}

int RunUserAdd(const UserOptions& options) {
  const std::optional<Role> role = ParseRole(options.role);
  if (!role || *role == Role::kGuest) {
    PrintError("--role '" + options.role +
               "': expected student, instructor, operator, admin or service");
    return kExitBadInput;
  }
  return WithAccounts(options.target, [&](Accounts& accounts) -> Result<std::string> {
    const std::string& name = options.name.empty() ? options.login : options.name;
    TRY(const auto account, accounts.Create(options.login, name, *role, Now()));
    Audit(accounts, "create_user", account, "");
    TRY(const auto link, accounts.CreateLink(account.id, Now()));
    return Line(account) + LinkText(account.login, link);
  });
}

int RunUserLink(const UserOptions& options) {
  return WithAccounts(options.target, [&](Accounts& accounts) -> Result<std::string> {
    TRY(const auto account, accounts.GetByLogin(options.login));
    TRY(const auto link, accounts.CreateLink(account.id, Now()));
    Audit(accounts, "reset_link", account, "faultlab admin");
    return LinkText(account.login, link);
  });
}

int RunUserDisable(const UserOptions& options) {
  return SetDisabled(options, true);
}

int RunUserEnable(const UserOptions& options) {
  return SetDisabled(options, false);
}

int RunKeyAdd(const KeyOptions& options) {
  constexpr int kDaysMax = 400;
  if (options.days < 1 || options.days > kDaysMax) {
    PrintError("--days must be 1 to " + std::to_string(kDaysMax));
    return kExitBadInput;
  }
  return WithAccounts(options.target, [&](Accounts& accounts) -> Result<std::string> {
    TRY(const auto account, accounts.GetByLogin(options.login));
    const WallTime now = Now();
    TRY(const auto key,
        accounts.CreateKey(Standing(account),
                           options.name,
                           {options.scopes.begin(), options.scopes.end()},
                           now + std::chrono::days(options.days),
                           now));
    return "Key " + std::to_string(key.key.id) + " of " + account.login +
           ", shown this once: send it as `Authorization: Bearer ..`\n  " + key.secret + "\n";
  });
}

int RunKeyList(const KeyOptions& options) {
  return WithAccounts(options.target, [&](Accounts& accounts) -> Result<std::string> {
    TRY(const auto account, accounts.GetByLogin(options.login));
    TRY(const auto keys, accounts.ListKeys(account.id, Now()));
    std::string text;
    for (const ApiKey& key : keys) {
      const bool expired = key.expires_at <= Now();
      text += std::to_string(key.id) + "\t" +
              (key.revoked ? "revoked"
               : expired   ? "expired"
                           : "good") +
              "\t" + key.name + "\t";
      for (const std::string& scope : key.scopes) {
        text += scope + " ";
      }
      text += "\n";
    }
    return text;
  });
}

int RunKeyRevoke(const KeyOptions& options) {
  return WithAccounts(options.target, [&](Accounts& accounts) -> Result<std::string> {
    TRY(const auto account, accounts.GetByLogin(options.login));
    TRY_DONE(accounts.RevokeKey(account.id, options.id, Now()));
    return "Key " + std::to_string(options.id) + " is revoked\n";
  });
}

int RunBackup(const BackupOptions& options) {
  umask(077);
  std::error_code ignored;
  if (fs::exists(options.file, ignored)) {
    PrintError("cannot write " + options.file + ": it exists; a backup never replaces a file");
    return kExitBadInput;
  }
  const Result<std::unique_ptr<Database>> database = OpenExisting(options.target);
  if (!database) {
    return Fail(database.error());
  }
  const Status saved = database.value()->BackupTo(options.file);
  return saved ? Print("Saved to " + options.file + "\n") : Fail(saved.error(), kExitFailure);
}

int RunRestore(const BackupOptions& options) {
  umask(077);
  const fs::path target = DatabaseFile(options.target);
  std::error_code error;
  if (!options.target.database_url.empty()) {
    PrintError("restore a PostgreSQL database with pg_restore");
    return kExitBadInput;
  }
  if (fs::exists(target, error)) {
    PrintError("there is a database at " + target.string() +
               "; stop the server and move it away first");
    return kExitBadInput;
  }
  if (!fs::exists(options.file, error)) {
    PrintError("cannot read " + options.file + ": no such file");
    return kExitBadInput;
  }
  // Opening a database may migrate it, so a copy is checked and installed; the backup itself is not
  // changed.
  fs::create_directories(options.target.data_dir, error);
  const fs::path copy = target.string() + ".part";
  fs::copy_file(options.file, copy, fs::copy_options::overwrite_existing, error);
  if (error) {
    PrintError("cannot write " + copy.string() + ": " + error.message());
    return kExitFailure;
  }
  Status good = core::Done{};
  {
    const Result<std::unique_ptr<Database>> database =
        Database::Open({.location = copy.string(), .existing = true});
    good = database ? CheckSchema(*database.value()) : Status(database.error());
    if (good) good = CheckDatabase(*database.value());
  }
  for (const char* suffix : {"-wal", "-shm"}) {
    fs::remove(copy.string() + suffix, error);
  }
  if (!good) {
    fs::remove(copy, error);
    PrintError(options.file + " is no sound backup: " + good.error().message);
    return kExitBadInput;
  }
  fs::rename(copy, target, error);
  if (error) {
    PrintError("cannot write " + target.string() + ": " + error.message());
    return kExitFailure;
  }
  return Print("Restored to " + target.string() + "\n");
}

int RunCheck(const CheckOptions& options) {
  const Result<std::unique_ptr<Database>> database = OpenExisting(options.target);
  if (!database) {
    return Fail(database.error());
  }
  if (options.cut_damage) {
    const Result<std::string> cut = CutAllDamage(*database.value());
    if (!cut) return Fail(cut.error(), kExitFailure);
    const int printed = Print(cut.value());
    if (printed != kExitOk) return printed;
  }
  Status sound = CheckSchema(*database.value());
  if (sound) sound = CheckDatabase(*database.value());
  return sound ? Print("The database is sound\n") : Fail(sound.error(), kExitFailure);
}

}  // namespace faultlab::server

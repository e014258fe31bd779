#include <CLI/CLI.hpp>
#include <memory>

#include "server/cli/add_command.h"
#include "server/cli/admin.h"
#include "server/cli/commands.h"
#include "server/cli/person_data.h"
#include "server/cli/retention.h"

namespace faultlab::server {
namespace {

void AddTarget(CLI::App& command, AdminTarget& target) {
  command.add_option("--data", target.data_dir, "Folder of the server's database")
      ->capture_default_str();
  command.add_option("--database", target.database_url, "postgresql://.. instead of the folder");
}

/// `faultlab admin ..`: the commands that use the database without the server.
class AdminCommands : Commands {
 public:
  AdminCommands(CLI::App& app, std::function<int()>& chosen) : Commands(chosen) {
    CLI::App& admin = *app.add_subcommand("admin", "Users, keys, backup, restore, check");
    admin.require_subcommand(1);
    admin.footer(
        "Examples:\n"
        "  faultlab admin users add ana --name \"Ana Petrović\" --role instructor\n"
        "  faultlab admin keys add ana --scope runs:read --scope runs:write --days 30\n"
        "  faultlab admin backup /var/backups/lab.db        while the server works");
    AddUsers(admin);
    AddKeys(admin);
    CLI::App& backup =
        Add(admin, "backup", "A consistent copy, while others work", backup_, &RunBackup);
    CLI::App& restore =
        Add(admin, "restore", "A backup into an empty folder", restore_, &RunRestore);
    backup.add_option("FILE", backup_.file, "New file")->required();
    restore.add_option("FILE", restore_.file, "Made by backup")->required();
    AddTarget(backup, backup_.target);
    AddTarget(restore, restore_.target);
    CLI::App& check = Add(admin, "check", "Integrity of the database", check_, &RunCheck);
    AddTarget(check, check_.target);
    check.add_flag("--cut-damage",
                   check_.cut_damage,
                   "Delete what cannot be read of damaged recordings, with an event in its place");
    AddRetention(admin);
  }

 private:
  void AddRetention(CLI::App& admin) {
    CLI::App& command = Add(admin,
                            "retention",
                            "Deletes what was kept long enough, as the server does daily",
                            retention_,
                            &RunRetention);
    AddTarget(command, retention_.target);
    command.add_flag("--dry-run", retention_.dry_run, "Only shows what would go");
    command.add_flag("--json", retention_.json, "One JSON object");
    RetentionRules& rules = retention_.rules;
    command.add_option("--guest-days", rules.guest_days, "Recordings of guests; 0 = for ever");
    command.add_option("--student-days", rules.student_days, "Recordings, after the last course");
    command.add_option("--job-days", rules.job_days, "Jobs and the recordings of their runs");
    command.add_option("--news-days", rules.news_days, "What users were told, old links");
    for (CLI::Option* option : command.get_options()) {
      if (option->get_name().ends_with("-days")) option->capture_default_str();
    }
  }
  void AddUsers(CLI::App& admin) {
    CLI::App& users = *admin.add_subcommand("users", "Accounts");
    users.require_subcommand(1);
    AddTarget(Add(users, "list", "All accounts", list_, &RunUserList), list_);
    struct Action {
      const char* name;
      const char* about;
      int (*run)(const UserOptions&);
    };
    for (const Action& action :
         {Action{"add", "Make an account, print its one-time link", &RunUserAdd},
          Action{"link", "A new one-time link that sets the password", &RunUserLink},
          Action{"disable", "End its sign-ins and keys", &RunUserDisable},
          Action{"enable", "Let it in again", &RunUserEnable}}) {
      CLI::App& command = Add(users, action.name, action.about, user_, action.run);
      command.add_option("LOGIN", user_.login, "3 to 64 of a-z 0-9 . _ @ -")->required();
      AddTarget(command, user_.target);
      if (action.run == &RunUserAdd) {
        command.add_option("--name", user_.name, "As others see it, in any script");
        command.add_option("--role", user_.role, "student, instructor, operator, admin or service")
            ->capture_default_str();
      }
    }
    CLI::App& exported = Add(users,
                             "export",
                             "What is kept of an account, into a new folder",
                             person_,
                             &RunPersonExport);
    CLI::App& erased = Add(
        users, "erase", "Takes a person out of the database for good", person_, &RunPersonErase);
    for (CLI::App* command : {&exported, &erased}) {
      command->add_option("LOGIN", person_.login, "Account")->required();
      AddTarget(*command, person_.target);
    }
    exported.add_option("FOLDER", person_.folder, "New folder")->required();
    erased.add_flag("--yes", person_.yes, "I know that it cannot be undone");
  }

  void AddKeys(CLI::App& admin) {
    CLI::App& keys = *admin.add_subcommand("keys", "API keys of an account");
    keys.require_subcommand(1);
    CLI::App& add = Add(keys, "add", "Make a key, print it once", key_, &RunKeyAdd);
    CLI::App& list = Add(keys, "list", "All keys of an account", key_, &RunKeyList);
    CLI::App& revoke = Add(keys, "revoke", "End a key", key_, &RunKeyRevoke);
    for (CLI::App* command : {&add, &list, &revoke}) {
      command->add_option("LOGIN", key_.login, "Account")->required();
      AddTarget(*command, key_.target);
    }
    add.add_option("--name", key_.name, "What it is for")->capture_default_str();
    add.add_option("--scope",
                   key_.scopes,
                   "runs:read, runs:write, jobs, lab, operate, people, courses, audit; repeatable");
    add.add_option("--days", key_.days, "Good for, at most 400")->capture_default_str();
    revoke.add_option("ID", key_.id, "Number of the key")->required();
  }

  AdminTarget list_;
  CheckOptions check_;
  UserOptions user_;
  PersonOptions person_;
  KeyOptions key_;
  BackupOptions backup_;
  BackupOptions restore_;
  RetentionOptions retention_;
};

}  // namespace

CommandGroup AddAdminCommands(CLI::App& app, std::function<int()>& chosen) {
  return std::make_shared<const AdminCommands>(app, chosen);
}

}  // namespace faultlab::server

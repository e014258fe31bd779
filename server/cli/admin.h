#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/types/result.h"
#include "server/storage/database.h"

namespace faultlab::server {

/// The database that an admin command uses.
struct AdminTarget {
  std::string data_dir = "data";  ///< holds faultlab.db
  std::string database_url;       ///< "postgresql://.."; empty: SQLite in data_dir
};

struct UserOptions {
  AdminTarget target;
  std::string login;
  std::string name;  ///< as shown to others; empty: the login
  std::string role = "student";
};

struct KeyOptions {
  AdminTarget target;
  std::string login;
  std::string name = "key";
  std::vector<std::string> scopes = {"runs:read"};
  int days = 90;
  std::int64_t id = 0;  ///< of the key to revoke
};

struct BackupOptions {
  AdminTarget target;
  std::string file;
};

struct CheckOptions {
  AdminTarget target;
  bool cut_damage = false;  ///< delete what cannot be read of damaged recordings
};

/// Opens an existing database; never makes a new one by accident.
core::Result<std::unique_ptr<Database>> OpenExisting(const AdminTarget& target);

/// All print to the standard output and return an exit status (console.h).
int RunUserList(const AdminTarget& target);
/// Makes the account and prints a one-time link secret (24 h) that sets its password.
int RunUserAdd(const UserOptions& options);
int RunUserLink(const UserOptions& options);
int RunUserDisable(const UserOptions& options);
int RunUserEnable(const UserOptions& options);

/// Prints the key, which cannot be shown again.
int RunKeyAdd(const KeyOptions& options);
int RunKeyList(const KeyOptions& options);
int RunKeyRevoke(const KeyOptions& options);

/// Copies the database consistently while the server works. The file must not exist.
int RunBackup(const BackupOptions& options);
/// Installs a checked backup in an empty data folder; refuses if there is a database.
int RunRestore(const BackupOptions& options);
/// The engine's own integrity check, and every chunk of every recording.
int RunCheck(const CheckOptions& options);

}  // namespace faultlab::server

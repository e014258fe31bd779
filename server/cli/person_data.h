#pragma once

#include <string>

#include "server/cli/admin.h"

namespace faultlab::server {

struct PersonOptions {
  AdminTarget target;
  std::string login;
  std::string folder;  ///< of an export: must not exist
  bool yes = false;    ///< of an erasure: confirmed on the command line
};

/// Writes everything that is stored about an account: person.json, and each recording as CSV.
int RunPersonExport(const PersonOptions& options);
/// Erases a person from the database for ever.
int RunPersonErase(const PersonOptions& options);

}  // namespace faultlab::server

#pragma once

#include <string>

#include "server/cli/admin.h"

namespace faultlab::server {

struct PersonOptions {
  AdminTarget target;
  std::string login;
  std::string folder;  ///< of an export: must not exist
  bool yes = false;    ///< of an erasure: asked for in words
};

/// Everything that is kept of an account: person.json, and each recording as CSV.
int RunPersonExport(const PersonOptions& options);
/// Takes a person out of the database for good.
int RunPersonErase(const PersonOptions& options);

}  // namespace faultlab::server

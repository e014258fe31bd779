#pragma once

#include "server/cli/admin.h"
#include "server/privacy/retention.h"

namespace faultlab::server {

struct RetentionOptions {
  AdminTarget target;
  RetentionRules rules;
  bool dry_run = false;
  bool json = false;
};

/// Deletes what the rules no longer keep, or only lists it; the server deletes the same once a day.
int RunRetention(const RetentionOptions& options);

}  // namespace faultlab::server

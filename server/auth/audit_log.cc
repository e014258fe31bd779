#include "server/auth/audit_log.h"

namespace faultlab::server {

void AuditLog::Add(const Principal& who,
                   const std::string& verb,
                   const std::string& object,
                   const std::string& detail) const {
  const std::string actor = who.owner_key();
  const core::Status kept = accounts_.Audit(actor, verb, object, detail, clock_.Wall());
  if (kept.ok()) return;
  log_("audit: \"" + verb + " " + object + "\" by " + actor +
       " is not in the audit log: " + kept.error().message);
}

}  // namespace faultlab::server

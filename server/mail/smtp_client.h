#pragma once

#include <string_view>

#include "server/mail/letter.h"
#include "server/mail/mail_settings.h"
#include "server/notify/attempt.h"

namespace faultlab::server::mail {

/// Hands mail to the server of the settings, encrypted: by SMTP with STARTTLS or by SMTPS. Blocks
/// for up to 30 s: never on a network thread. Thread-safe.
class SmtpClient {
 public:
  explicit SmtpClient(MailSettings settings);

  /// "smtp://HOST[:PORT]" or "smtps://..", without a user.
  static bool IsServer(std::string_view url);

  /// kNever: the address was refused for good; its error is the server's. What concerns all mail (a
  /// wrong password, a server that is away or wants to have less) is kNotNow.
  notify::Attempt Send(const Letter& letter) const;

 private:
  const MailSettings settings_;
};

}  // namespace faultlab::server::mail

#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "server/auth/accounts.h"
#include "server/clock.h"
#include "server/mail/smtp_client.h"
#include "server/notify/channel.h"

namespace faultlab::server::mail {

/// Mails students who cannot sign in yet the link that opens their account
/// (Accounts::ListUnopened). The link is made when its mail is sent: no secret waits in the
/// database. A server that is killed between the two sends another one, and both work until one is
/// used. Thread-safe.
class ClassMail : public notify::Channel {
 public:
  /// All parts must outlive it.
  /// @param base_url  of the lab, as browsers know it
  ClassMail(Database& database,
            Accounts& accounts,
            MailSettings settings,
            std::string base_url,
            const Clock& clock);

  /// Where answers go; empty: this lab sends no mail.
  std::string from() const { return is_on() ? settings_.from : std::string(); }

  struct Queued {
    std::int64_t count = 0;
    std::vector<std::string> without;  ///< logins of whom no address is known
  };
  /// One for each that has none waiting. kConflict "no_mail".
  core::Result<Queued> Queue(const Principal& who,
                             std::int64_t course,
                             const std::string& course_name,
                             bool but_addresses,
                             bool serbian,
                             WallTime now);

  struct Sent {
    std::string login;
    WallTime at{};
    std::string state;  ///< "waiting", "delivered", "given_up"
    std::int64_t attempts = 0;
    std::string error;  ///< of the last attempt: what the mail server said
  };
  /// Of a course: the newest of each student, the newest first.
  core::Result<std::vector<Sent>> SentTo(std::int64_t course);

  std::string_view prefix() const override { return notify::kMailChannel; }
  bool is_on() const override { return !settings_.smtp.empty(); }
  core::Result<bool> Gather(WallTime) override { return false; }  // Queue has done it
  notify::Attempt Send(const notify::Message& message) override;

 private:
  Database& database_;
  Accounts& accounts_;
  const MailSettings settings_;
  const SmtpClient client_;
  const std::string base_url_;
  const Clock& clock_;
};

}  // namespace faultlab::server::mail

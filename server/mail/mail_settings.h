#pragma once

#include <string>

namespace faultlab::server::mail {

/// The mail server that takes this lab's mail, and in whose name.
struct MailSettings {
  std::string
      smtp;  ///< "smtp://mail.example.org:587" (with STARTTLS), "smtps://..:465"; empty: none
  std::string user;  ///< empty: without signing in
  std::string password;
  std::string from;                ///< "lab@example.org"
  int per_minute = 30;             ///< that the provider takes
  std::string ca_file;             ///< PEM; empty: the system's
  bool insecure_loopback = false;  ///< smtp://127.0.0.1 without encryption: for tests
};

}  // namespace faultlab::server::mail

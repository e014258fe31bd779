#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/types/result.h"
#include "server/camera/camera_settings.h"
#include "server/mail/mail_settings.h"
#include "server/net/trusted_proxies.h"
#include "server/oidc/provider_settings.h"

namespace faultlab::server {

/// A class of rigs, and how many of it this server simulates: [[bench]].
struct BenchSettings {
  std::string file;     ///< its description, or the name of a shipped one; empty: the paper's
  int simulators = 4;   ///< for practice
  std::string profile;  ///< what they simulate; empty: the bench's usual one
  int lab = 0;          ///< that need a session
};

/// All settings of a server; every one has a default that works on a laptop.
struct Config {
  std::string listen = "127.0.0.1:8080";
  std::string data_dir = "data";
  std::string database_url;         ///< "postgresql://.."; empty: SQLite in data_dir
  std::string server_id = "local";  ///< distinguishes the servers that share one database
  /// "10.0.0.2:8080": the address at which those servers reach this one; empty: the address in
  /// `listen`.
  std::string member_address;
  std::vector<std::string> allowed_hosts;  ///< names a Host header may carry; see HttpServerOptions
  TrustedProxies trusted_proxies;          ///< besides loopback; see HttpServerOptions
  /// Clients that may use the experiment without an account: loopback | everywhere | never.
  std::string guests = "loopback";
  std::string log_level = "info";

  /// The first is the usual one. Empty: the paper's alone, simulated as the next three say.
  std::vector<BenchSettings> benches;
  int sim_rigs = 4;
  int lab_benches = 0;      ///< simulated benches that need a session
  std::string sim_profile;  ///< as BenchSettings::profile
  double sim_speed = 1.0;
  int runs_max = 32;  ///< at the same time, in addition to those of sessions
  int runs_per_caller_max = 8;
  int replayed_samples_max = 2'000'000;
  // Longer ones are in memory one at a time: see server/experiment/long_turn.h. No key sets them.
  std::int64_t short_samples_max = 200'000;  ///< 33 min at 100 Hz
  std::size_t short_text_bytes_max = 16 << 20;
  std::optional<std::uint64_t> fixture_seed;

  std::string public_url;  ///< "https://lab.example.org", as browsers know it; empty: by Host
  std::vector<oidc::ProviderSettings> providers;  ///< sign-in services besides local accounts

  std::vector<int> reminders_min{720, 15};  ///< before a booking; empty: none
  bool webhooks_insecure_local = false;     ///< webhooks may be http:// in the local network
  std::string webhooks_ca_file;             ///< PEM, instead of the system's authorities
  std::string lti_ca_file;                  ///< the same for learning platforms
  bool lti_insecure_loopback = false;       ///< they may be http://127.0.0.1: for tests
  mail::MailSettings mail;                  ///< without `smtp` none is sent

  std::vector<CameraSettings> cameras;  ///< one for each rig at most

  std::string lcm_url;   ///< live tap and remote rigs; empty: neither
  std::string lcm_keys;  ///< folder of ID.key files; empty: the default of the rig finder

  // How many days things are kept; 0 = for ever. See server/privacy/retention.h.
  int keep_guest_days = 30;
  int keep_student_days = 365;
  int keep_job_days = 90;
  int keep_news_days = 365;

  // How much is kept; 0 = no limit. See server/experiment/storage_quota.h.
  int samples_per_account = 20'000'000;
  int samples_of_guests = 10'000'000;
  int disk_reserve_mb = 512;

  int viewers_max = 4096;
  int connections_max = 4096;
  int pool_threads = 4;
};

/// Reads a TOML text. An unknown key, a wrong kind or a value out of range is refused as
/// "file:line: key: what was expected".
core::Result<Config> ParseConfig(std::string_view text, const std::string& file_name);
core::Result<Config> LoadConfig(const std::string& path);

}  // namespace faultlab::server

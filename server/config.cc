#include "server/config.h"

#include <algorithm>
#include <cstdlib>

#include "hardware/config/toml_table.h"
#include "server/camera/camera_reader.h"
#include "server/mail/smtp_client.h"

namespace faultlab::server {
namespace {

bool IsWord(const std::string& text) {
  return !text.empty() && text.size() <= 32 &&
         text.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-") == std::string::npos;
}

/// The secret is read from a file or from the environment, which fewer people can read.
/// @param name  "client_secret": in NAME_file or NAME_env
std::string Secret(hardware::TomlTable& in, const std::string& name) {
  const std::string file_key = name + "_file";
  const std::string variable_key = name + "_env";
  std::string file;
  std::string variable;
  in.Text(file_key, file);
  in.Text(variable_key, variable);
  std::string secret;
  if (!file.empty()) {
    const core::Result<std::string> text = hardware::LoadText(file);
    if (!text) in.Refuse(file_key, "cannot be read: " + text.error().message);
    secret = text.value();
  } else if (!variable.empty()) {
    const char* value = std::getenv(variable.c_str());
    if (value == nullptr) in.Refuse(variable_key, "is not in the environment");
    secret = value;
  }
  while (!secret.empty() && (secret.back() == '\n' || secret.back() == '\r')) secret.pop_back();
  return secret;
}

oidc::ProviderSettings ReadProvider(hardware::TomlTable& in,
                                    const std::vector<oidc::ProviderSettings>& before) {
  oidc::ProviderSettings out;
  in.Text("id", out.id);
  if (!IsWord(out.id)) in.Refuse("id", "must be 1 to 32 of a-z, 0-9 and -");
  for (const oidc::ProviderSettings& other : before) {
    if (other.id == out.id) in.Refuse("id", "is taken by another provider");
  }
  out.label = out.id;
  in.Text("label", out.label);
  in.Text("issuer", out.issuer);
  in.Text("client_id", out.client_id);
  in.Flag("insecure_loopback", out.insecure_loopback);
  const bool secure = out.issuer.starts_with("https://");
  if (!secure && !(out.insecure_loopback && out.issuer.starts_with("http://"))) {
    in.Refuse("issuer", "must be an address https://..");
  }
  if (out.client_id.empty()) in.Refuse("client_id", "must be given");
  out.client_secret = Secret(in, "client_secret");
  in.Texts("scopes", out.scopes);
  if (std::find(out.scopes.begin(), out.scopes.end(), "openid") == out.scopes.end()) {
    in.Refuse("scopes", "must hold \"openid\"");
  }
  in.Text("login_claim", out.admission.login_claim);
  in.Texts("allowed_domains", out.admission.allowed_domains);
  in.Text("required_claim", out.admission.required_claim);
  const std::size_t equals = out.admission.required_claim.find('=');
  if (!out.admission.required_claim.empty() && (equals == 0 || equals == std::string::npos)) {
    in.Refuse("required_claim", "must be \"name=value\"");
  }
  in.Flag("make_accounts", out.make_accounts);
  in.Flag("claim_class_list", out.claim_class_list);
  in.Text("ca_file", out.ca_file);
  return out;
}

constexpr const char* kOfEachBench = "stands in each [[bench]] when there are some";

BenchSettings ReadBench(hardware::TomlTable& in) {
  BenchSettings out;
  in.Text("file", out.file);
  if (out.file.empty()) in.Refuse("file", "is missing: the description of the bench");
  in.Integer("simulators", out.simulators, 0, 10'000);
  in.Text("profile", out.profile);
  in.Integer("lab", out.lab, 0, 64);
  return out;
}

CameraSettings ReadCamera(hardware::TomlTable& in, const std::vector<CameraSettings>& before) {
  CameraSettings out;
  in.Text("rig", out.rig);
  if (out.rig.empty()) in.Refuse("rig", "is missing: the id of the rig that the camera looks at");
  for (const CameraSettings& other : before) {
    if (other.rig == out.rig) in.Refuse("rig", "has another camera already");
  }
  in.Text("snapshot", out.snapshot);
  const core::Status address = CameraReader::CheckAddress(out.snapshot);
  if (!address.ok()) in.Refuse("snapshot", address.error().message);
  double timeout_s = std::chrono::duration<double>(out.timeout).count();
  in.Number("timeout_s", timeout_s, 0.5, 10.0);
  out.timeout =
      std::chrono::round<std::chrono::milliseconds>(std::chrono::duration<double>(timeout_s));
  return out;
}

mail::MailSettings ReadMail(hardware::TomlTable& in, const std::string& public_url) {
  mail::MailSettings out;
  in.Text("smtp", out.smtp);
  in.Text("user", out.user);
  out.password = Secret(in, "password");
  in.Text("from", out.from);
  in.Integer("per_minute", out.per_minute, 1, 10'000);
  in.Text("ca_file", out.ca_file);
  in.Flag("insecure_loopback", out.insecure_loopback);
  if (out.smtp.empty()) return out;
  if (!mail::SmtpClient::IsServer(out.smtp)) {
    in.Refuse("smtp", "must be \"smtp://HOST:587\" or \"smtps://HOST:465\"");
  }
  if (!mail::IsAddress(out.from)) in.Refuse("from", "must be an address of mail");
  if (public_url.empty()) in.Refuse("smtp", "needs public_url: mails carry links to this lab");
  return out;
}

void Read(hardware::TomlTable& in, Config& config) {
  in.Text("listen", config.listen);
  in.Text("data_dir", config.data_dir);
  in.Text("server_id", config.server_id);
  in.Text("member_address", config.member_address);
  in.Texts("allowed_hosts", config.allowed_hosts);
  std::vector<std::string> proxies;
  in.Texts("trusted_proxies", proxies);
  auto trusted = TrustedProxies::Parse(proxies);
  if (!trusted) in.Refuse("trusted_proxies", trusted.error().message);
  config.trusted_proxies = std::move(trusted).value();
  in.Text("public_url", config.public_url);
  in.Word("guests", config.guests, {"loopback", "everywhere", "never"});
  in.Word("log_level", config.log_level, {"trace", "debug", "info", "warn", "error"});

  hardware::TomlTable& database = in.Sub("database");
  database.Text("url", config.database_url);

  hardware::TomlTable& simulators = in.Sub("simulators");
  simulators.Integer("count", config.sim_rigs, 0, 10'000);
  simulators.Text("profile", config.sim_profile);
  simulators.Number("speed", config.sim_speed, 0.0, 1000.0);
  simulators.Seed("seed", config.fixture_seed);

  hardware::TomlTable& lab = in.Sub("lab");
  lab.Integer("benches", config.lab_benches, 0, 64);

  for (hardware::TomlTable* bench : in.Subs("bench")) {
    config.benches.push_back(ReadBench(*bench));
  }
  if (!config.benches.empty()) {
    for (const char* key : {"count", "profile"}) {
      if (simulators.Has(key)) simulators.Refuse(key, kOfEachBench);
    }
    if (lab.Has("benches")) lab.Refuse("benches", kOfEachBench);
  }

  hardware::TomlTable& retention = in.Sub("retention");
  retention.Integer("guest_days", config.keep_guest_days, 0, 36'500);
  retention.Integer("student_days", config.keep_student_days, 0, 36'500);
  retention.Integer("job_days", config.keep_job_days, 0, 36'500);
  retention.Integer("news_days", config.keep_news_days, 0, 36'500);

  hardware::TomlTable& limits = in.Sub("limits");
  limits.Integer("runs", config.runs_max, 1, 1000);
  limits.Integer("runs_per_caller", config.runs_per_caller_max, 1, 1000);
  limits.Integer("replayed_samples", config.replayed_samples_max, 1'000, 1'000'000'000);
  limits.Integer("viewers", config.viewers_max, 1, 100'000);
  limits.Integer("connections", config.connections_max, 1, 100'000);
  limits.Integer("pool_threads", config.pool_threads, 1, 64);

  hardware::TomlTable& storage = in.Sub("storage");
  storage.Integer("samples_per_account", config.samples_per_account, 0, 2'000'000'000);
  storage.Integer("samples_of_guests", config.samples_of_guests, 0, 2'000'000'000);
  storage.Integer("disk_reserve_mb", config.disk_reserve_mb, 0, 1'000'000);
  constexpr int kLeastReserveMb = 32;
  if (config.disk_reserve_mb > 0 && config.disk_reserve_mb < kLeastReserveMb) {
    storage.Refuse("disk_reserve_mb",
                   "must be 0 (none) or at least 32: deletions on a full disk need it");
  }

  hardware::TomlTable& notify = in.Sub("notify");
  notify.Integers("reminders_min", config.reminders_min, 1, 7 * 24 * 60);
  hardware::TomlTable& webhooks = in.Sub("webhooks");
  webhooks.Flag("insecure_local", config.webhooks_insecure_local);
  webhooks.Text("ca_file", config.webhooks_ca_file);
  hardware::TomlTable& lti = in.Sub("lti");
  lti.Text("ca_file", config.lti_ca_file);
  lti.Flag("insecure_loopback", config.lti_insecure_loopback);

  config.mail = ReadMail(in.Sub("mail"), config.public_url);

  hardware::TomlTable& lcm = in.Sub("lcm");
  lcm.Text("url", config.lcm_url);
  lcm.Text("keys", config.lcm_keys);

  for (hardware::TomlTable* camera : in.Subs("camera")) {
    config.cameras.push_back(ReadCamera(*camera, config.cameras));
  }

  for (hardware::TomlTable* provider : in.Subs("oidc")) {
    config.providers.push_back(ReadProvider(*provider, config.providers));
  }
}

}  // namespace

core::Result<Config> ParseConfig(std::string_view text, const std::string& file_name) {
  Config config;
  TRY_DONE(hardware::ReadToml(
      text, file_name, [&config](hardware::TomlTable& root) { Read(root, config); }));
  return config;
}

core::Result<Config> LoadConfig(const std::string& path) {
  TRY(const auto text, hardware::LoadText(path));
  return ParseConfig(text, path);
}

}  // namespace faultlab::server

#include "server/config.h"

#include "hardware/config/toml_table.h"

namespace faultlab::server {
namespace {

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
  in.Word("guests", config.guests, {"loopback", "everywhere", "never"});
  in.Word("log_level", config.log_level, {"trace", "debug", "info", "warn", "error"});

  hardware::TomlTable& database = in.Sub("database");
  database.Text("url", config.database_url);

  hardware::TomlTable& simulators = in.Sub("simulators");
  simulators.Integer("count", config.sim_rigs, 0, 10'000);
  simulators.Word("profile", config.sim_profile, {"bench", "multisim"});
  simulators.Number("speed", config.sim_speed, 0.0, 1000.0);
  simulators.Seed("seed", config.fixture_seed);

  hardware::TomlTable& lab = in.Sub("lab");
  lab.Integer("benches", config.lab_benches, 0, 64);

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

  hardware::TomlTable& lcm = in.Sub("lcm");
  lcm.Text("url", config.lcm_url);
  lcm.Text("keys", config.lcm_keys);
}

}  // namespace

core::Result<Config> ParseConfig(std::string_view text, const std::string& file_name) {
  Config config;
  const core::Status read = hardware::ReadToml(
      text, file_name, [&config](hardware::TomlTable& root) { Read(root, config); });
  if (!read.ok()) return read.error();
  return config;
}

core::Result<Config> LoadConfig(const std::string& path) {
  const core::Result<std::string> text = hardware::LoadText(path);
  if (!text) return text.error();
  return ParseConfig(text.value(), path);
}

}  // namespace faultlab::server

#include "server/config.h"

#include <toml++/toml.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <sstream>

namespace faultlab::server {
namespace {

/// Reads one table strictly; what is not asked for is refused by name. Keeps the first refusal.
class TableReader {
 public:
  TableReader(const toml::table& table, std::string prefix, const std::string& file)
      : table_(table), prefix_(std::move(prefix)), file_(file) {}

  void Text(std::string_view key, std::string& out) {
    Read<std::string>(key, out, "a text", [](const std::string&) { return true; });
  }
  void Word(std::string_view key, std::string& out, std::initializer_list<std::string_view> words) {
    std::string expected = "one of";
    for (const std::string_view word : words) expected.append(" \"").append(word).append("\"");
    Read<std::string>(key, out, expected, [words](const std::string& value) {
      return std::find(words.begin(), words.end(), value) != words.end();
    });
  }
  void Integer(std::string_view key, int& out, int lo, int hi) {
    std::int64_t value = out;
    Read<std::int64_t>(key,
                       value,
                       "a whole number from " + std::to_string(lo) + " to " + std::to_string(hi),
                       [lo, hi](std::int64_t v) { return v >= lo && v <= hi; });
    out = static_cast<int>(value);
  }
  void Number(std::string_view key, double& out, double lo, double hi) {
    Read<double>(key, out, "a number in range", [lo, hi](double v) { return v >= lo && v <= hi; });
  }
  void Seed(std::string_view key, std::optional<std::uint64_t>& out) {
    if (!table_.contains(key)) {
      asked_.emplace(key);
      return;
    }
    std::int64_t value = 0;
    Read<std::int64_t>(key, value, "a whole number", [](std::int64_t v) { return v >= 0; });
    out = static_cast<std::uint64_t>(value);
  }
  void Texts(std::string_view key, std::vector<std::string>& out) {
    const toml::node* node = Find(key);
    if (node == nullptr) return;
    const toml::array* list = node->as_array();
    if (list == nullptr) return Refuse(key, *node, "a list of texts");
    for (const toml::node& entry : *list) {
      const auto text = entry.value_exact<std::string>();
      if (!text) return Refuse(key, entry, "a list of texts");
      out.push_back(*text);
    }
  }
  const toml::table* Table(std::string_view key) {
    const toml::node* node = Find(key);
    if (node == nullptr) return nullptr;
    if (!node->is_table()) Refuse(key, *node, "a table");
    return node->as_table();
  }
  void Take(const std::optional<core::Error>& error) {
    if (!error_) error_ = error;
  }
  std::optional<core::Error> Finish() {
    for (const auto& [key, node] : table_) {
      if (asked_.contains(key.str())) continue;
      Refuse(key.str(), node, "absent: there is no such setting");
    }
    return error_;
  }

 private:
  const toml::node* Find(std::string_view key) {
    asked_.emplace(key);
    return table_.get(key);
  }
  void Refuse(std::string_view key, const toml::node& node, const std::string& expected) {
    if (error_) return;
    const std::string name = prefix_ + std::string(key);
    error_ = core::Error{core::ErrorCode::kInvalid,
                         file_ + ":" + std::to_string(node.source().begin.line) + ": " + name +
                             " must be " + expected,
                         name};
  }
  template <typename T, typename Accept>
  void Read(std::string_view key, T& out, const std::string& expected, Accept accept) {
    const toml::node* node = Find(key);
    if (node == nullptr) return;
    const auto value = node->value<T>();
    if (!value || !accept(*value)) return Refuse(key, *node, expected);
    out = *value;
  }

  const toml::table& table_;
  std::string prefix_;
  const std::string& file_;
  std::set<std::string, std::less<>> asked_;
  std::optional<core::Error> error_;
};

void ReadLcm(TableReader& in, const std::string& file, Config& config) {
  const toml::table* table = in.Table("lcm");
  if (table == nullptr) return;
  TableReader lcm(*table, "lcm.", file);
  lcm.Text("url", config.lcm_url);
  lcm.Text("keys", config.lcm_keys);
  in.Take(lcm.Finish());
}

Config ReadAll(TableReader& in, const std::string& file) {
  Config config;
  in.Text("listen", config.listen);
  in.Text("data_dir", config.data_dir);
  in.Text("server_id", config.server_id);
  in.Texts("allowed_hosts", config.allowed_hosts);
  in.Word("guests", config.guests, {"loopback", "everywhere", "never"});
  in.Word("log_level", config.log_level, {"trace", "debug", "info", "warn", "error"});
  if (const toml::table* table = in.Table("database")) {
    TableReader database(*table, "database.", file);
    database.Text("url", config.database_url);
    in.Take(database.Finish());
  }
  if (const toml::table* table = in.Table("simulators")) {
    TableReader simulators(*table, "simulators.", file);
    simulators.Integer("count", config.sim_rigs, 0, 10'000);
    simulators.Word("profile", config.sim_profile, {"bench", "multisim"});
    simulators.Number("speed", config.sim_speed, 0.0, 1000.0);
    simulators.Seed("seed", config.fixture_seed);
    in.Take(simulators.Finish());
  }
  if (const toml::table* table = in.Table("lab")) {
    TableReader lab(*table, "lab.", file);
    lab.Integer("benches", config.lab_benches, 0, 64);
    in.Take(lab.Finish());
  }
  if (const toml::table* table = in.Table("retention")) {
    TableReader retention(*table, "retention.", file);
    retention.Integer("guest_days", config.keep_guest_days, 0, 36'500);
    retention.Integer("student_days", config.keep_student_days, 0, 36'500);
    retention.Integer("job_days", config.keep_job_days, 0, 36'500);
    retention.Integer("news_days", config.keep_news_days, 0, 36'500);
    in.Take(retention.Finish());
  }
  if (const toml::table* table = in.Table("limits")) {
    TableReader limits(*table, "limits.", file);
    limits.Integer("runs", config.runs_max, 1, 1000);
    limits.Integer("viewers", config.viewers_max, 1, 100'000);
    limits.Integer("connections", config.connections_max, 1, 100'000);
    limits.Integer("pool_threads", config.pool_threads, 1, 64);
    in.Take(limits.Finish());
  }
  ReadLcm(in, file, config);
  return config;
}

}  // namespace

core::Result<Config> ParseConfig(std::string_view text, const std::string& file_name) {
  try {
    const toml::table table = toml::parse(text, file_name);
    TableReader in(table, "", file_name);
    Config config = ReadAll(in, file_name);
    if (auto error = in.Finish()) return *error;
    return config;
  } catch (const toml::parse_error& error) {
    return core::Error{core::ErrorCode::kInvalid,
                       file_name + ":" + std::to_string(error.source().begin.line) + ": " +
                           std::string(error.description()),
                       {}};
  }
}

core::Result<Config> LoadConfig(const std::string& path) {
  std::ifstream in(path);
  std::ostringstream text;
  text << in.rdbuf();
  if (!in) {
    return core::Error{
        core::ErrorCode::kNotFound, path + ": cannot be read; is it a file?", "config"};
  }
  return ParseConfig(text.str(), path);
}

}  // namespace faultlab::server

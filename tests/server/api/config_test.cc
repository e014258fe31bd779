#include "server/config.h"

#include <gtest/gtest.h>

#include <cstdlib>

namespace faultlab::server {
namespace {

TEST(Config, ReadsEverySetting) {
  const auto parsed = ParseConfig(R"(
listen = "0.0.0.0:80"
data_dir = "/var/lib/faultlab"
server_id = "a"
member_address = "10.0.0.2:80"
allowed_hosts = ["lab.example"]
guests = "never"
log_level = "debug"
[database]
url = "postgresql://lab@db/lab"
[simulators]
count = 2
profile = "multisim"
speed = 20
seed = 7
[limits]
runs = 5
viewers = 100
connections = 200
pool_threads = 2
[lcm]
url = "memq://"
keys = "/etc/faultlab/keys"
[[camera]]
rig = "bench-1"
snapshot = "http://127.0.0.1:8081/snapshot"
[[camera]]
rig = "bench-2"
snapshot = "https://cameras.example.org/2.jpg"
timeout_s = 7.5
[[oidc]]
id = "uni"
label = "Univerzitet"
issuer = "https://login.uns.ac.rs"
client_id = "faultlab"
client_secret_env = "PATH"
scopes = ["openid"]
login_claim = "email"
allowed_domains = ["uns.ac.rs"]
required_claim = "affiliation=student"
make_accounts = false
claim_class_list = true
ca_file = "/etc/ssl/uni.pem"
[[oidc]]
id = "test"
issuer = "http://127.0.0.1:1"
client_id = "c"
insecure_loopback = true
)",
                                  "f.toml");
  ASSERT_TRUE(parsed.ok()) << parsed.error().message;
  const Config& config = parsed.value();
  EXPECT_EQ(config.listen, "0.0.0.0:80");
  EXPECT_EQ(config.member_address, "10.0.0.2:80");
  EXPECT_EQ(config.allowed_hosts, std::vector<std::string>{"lab.example"});
  EXPECT_EQ(config.guests, "never");
  EXPECT_EQ(config.database_url, "postgresql://lab@db/lab");
  EXPECT_EQ(config.sim_rigs, 2);
  EXPECT_EQ(config.sim_profile, "multisim");
  EXPECT_EQ(config.sim_speed, 20.0);
  EXPECT_EQ(config.fixture_seed, 7u);
  EXPECT_EQ(config.runs_max, 5);
  EXPECT_EQ(config.pool_threads, 2);
  EXPECT_EQ(config.lcm_keys, "/etc/faultlab/keys");
  ASSERT_EQ(config.cameras.size(), 2u);
  EXPECT_EQ(config.cameras[0].rig, "bench-1");
  EXPECT_EQ(config.cameras[0].snapshot, "http://127.0.0.1:8081/snapshot");
  EXPECT_EQ(config.cameras[1].snapshot, "https://cameras.example.org/2.jpg");
  EXPECT_EQ(config.cameras[0].timeout, std::chrono::milliseconds(2000));
  EXPECT_EQ(config.cameras[1].timeout, std::chrono::milliseconds(7500));
  ASSERT_EQ(config.providers.size(), 2u);
  const oidc::ProviderSettings& uni = config.providers[0];
  EXPECT_EQ(uni.id, "uni");
  EXPECT_EQ(uni.label, "Univerzitet");
  EXPECT_EQ(uni.issuer, "https://login.uns.ac.rs");
  EXPECT_EQ(uni.client_secret, std::getenv("PATH"));
  EXPECT_EQ(uni.scopes, std::vector<std::string>{"openid"});
  EXPECT_EQ(uni.admission.login_claim, "email");
  EXPECT_EQ(uni.admission.allowed_domains, std::vector<std::string>{"uns.ac.rs"});
  EXPECT_EQ(uni.admission.required_claim, "affiliation=student");
  EXPECT_FALSE(uni.make_accounts);
  EXPECT_TRUE(uni.claim_class_list);
  EXPECT_EQ(uni.ca_file, "/etc/ssl/uni.pem");
  EXPECT_EQ(config.providers[1].label, "test") << "its id where nothing else is said";
  EXPECT_TRUE(config.providers[1].insecure_loopback);
}

TEST(Config, NeedsNoFileAtAll) {
  EXPECT_TRUE(ParseConfig("", "f.toml").ok());
}

TEST(Config, NamesFileLineAndSetting) {
  const struct {
    const char* text;
    const char* start;
  } cases[] = {
      {"listen = 80\n", "f.toml:1: listen must be a text"},
      {"\nlisten_on = \"x\"\n", "f.toml:2: listen_on is not a key"},
      {"[limits]\nruns = 0\n", "f.toml:2: limits.runs must be a whole number from 1 to 1000"},
      {"guests = \"all\"\n", "f.toml:1: guests must be one of"},
      {"[simulators]\nspeed = -1\n", "f.toml:2: simulators.speed must be"},
      {"lcm = 3\n", "f.toml:1: lcm must be a table"},
      {"[lab]\nbenches = 2.0\n", "f.toml:2: lab.benches must be a whole number from 0 to 64"},
      {"[simulators]\nseed = -1\n", "f.toml:2: simulators.seed must be a whole number, 0 or more"},
      {"allowed_hosts = [\"a\", 3]\n", "f.toml:1: allowed_hosts must be a list of texts"},
      {"\n[limit]\nruns = 3\n", "f.toml:2: limit is not a key"},
      {"[storage]\ndisk_reserve_mb = 8\n",
       "f.toml:2: storage.disk_reserve_mb must be 0 (none) or at least 32"},
      {"a = [1\n", "f.toml:"},
      {"oidc = 3\n", "f.toml:1: oidc must be a list of tables: [[oidc]]"},
      {"[[oidc]]\nid = \"Uni!\"\n", "f.toml:2: oidc.id must be"},
      {"[[oidc]]\nid = \"a\"\nissuer = \"http://127.0.0.1\"\n",
       "f.toml:3: oidc.issuer must be an address https"},
      {"[[oidc]]\nid = \"a\"\nissuer = \"https://x\"\nclient_id = \"c\"\nsecret = \"s\"\n",
       "f.toml:5: oidc.secret is not a key"},
      {"[[oidc]]\nid = \"a\"\nissuer = \"https://x\"\nclient_id = \"c\"\n"
       "client_secret_file = \"/no/such\"\n",
       "f.toml:5: oidc.client_secret_file cannot be read"},
      {"[[camera]]\nsnapshot = \"http://127.0.0.1/\"\n", "f.toml:1: camera.rig is missing"},
      {"[[camera]]\nrig = \"a\"\nsnapshot = \"http://example.org/\"\n",
       "f.toml:3: camera.snapshot must be the address of a picture"},
      {"[[camera]]\nrig = \"a\"\nsnapshot = \"http://[::1]/\"\ntimeout_s = 11\n",
       "f.toml:4: camera.timeout_s must be"},
      {"[[camera]]\nrig = \"a\"\nsnapshot = \"http://[::1]/\"\n"
       "[[camera]]\nrig = \"a\"\nsnapshot = \"http://[::1]/\"\n",
       "f.toml:5: camera.rig has another camera already"},
  };
  for (const auto& wrong : cases) {
    const auto parsed = ParseConfig(wrong.text, "f.toml");
    ASSERT_FALSE(parsed.ok()) << wrong.text;
    EXPECT_TRUE(parsed.error().message.starts_with(wrong.start)) << parsed.error().message;
  }
}

TEST(Config, SaysThatAFileIsNotThere) {
  const auto loaded = LoadConfig("/no/such/file.toml");
  ASSERT_FALSE(loaded.ok());
  EXPECT_NE(loaded.error().message.find("/no/such/file.toml"), std::string::npos);
}

}  // namespace
}  // namespace faultlab::server

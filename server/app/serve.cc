#include "server/app/serve.h"

#include <malloc.h>
#include <pthread.h>
#include <signal.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <cstdio>
#include <string>
#include <utility>

#include "server/app/application.h"

namespace faultlab::server {
namespace {

constexpr int kStarted = 0;
constexpr int kCannotStart = 1;
constexpr int kBadConfig = 2;

core::Result<Config> Settings(const ServeOptions& options) {
  Config config;
  if (!options.config_path.empty()) {
    TRY(config, LoadConfig(options.config_path));
  }
  if (options.listen) config.listen = *options.listen;
  if (options.data_dir) config.data_dir = *options.data_dir;
  if (options.lcm_url) config.lcm_url = *options.lcm_url;
  for (const std::string& file : options.benches) {
    config.benches.push_back({file, options.sim_rigs.value_or(config.sim_rigs), "", 0});
  }
  if (options.sim_rigs) config.sim_rigs = *options.sim_rigs;
  if (options.sim_speed) config.sim_speed = *options.sim_speed;
  if (options.fixture_seed) config.fixture_seed = *options.fixture_seed;
  if (options.log_level) config.log_level = *options.log_level;
  return config;
}

/// Every viewer needs a descriptor; Debian's soft limit is 1024.
void RaiseDescriptorLimit() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max;
  if (setrlimit(RLIMIT_NOFILE, &limit) != 0) spdlog::warn("cannot raise the descriptor limit");
}

/// Returns memory from a burst of large answers to the system; otherwise the heaps of some sixty
/// threads would keep it for ever.
void ReturnFreedMemory() {
  mallopt(M_ARENA_MAX, 4);
  mallopt(M_MMAP_THRESHOLD, 512 << 10);
  mallopt(M_TRIM_THRESHOLD, 1 << 20);
}

}  // namespace

int Serve(const ServeOptions& options) {
  auto settings = Settings(options);
  if (!settings) {
    std::fprintf(stderr, "faultlab: %s\n", settings.error().message.c_str());
    return kBadConfig;
  }
  const Config& config = settings.value();
  spdlog::set_default_logger(spdlog::stderr_color_mt("faultlab"));
  spdlog::set_level(spdlog::level::from_str(config.log_level));

  ReturnFreedMemory();
  // Every thread inherits the mask, so that only sigwait receives signals.
  sigset_t ends;
  sigemptyset(&ends);
  sigaddset(&ends, SIGTERM);
  sigaddset(&ends, SIGINT);
  pthread_sigmask(SIG_BLOCK, &ends, nullptr);
  signal(SIGPIPE, SIG_IGN);
  RaiseDescriptorLimit();
  umask(077);  // files written contain password hashes and students' work

  auto application = Application::Open(config);
  if (!application) {
    std::fprintf(stderr, "faultlab: %s\n", application.error().message.c_str());
    return kCannotStart;
  }
  std::printf("faultlab listening on http://%s\n", application.value()->address().c_str());
  std::fflush(stdout);

  int signal_number = 0;
  sigwait(&ends, &signal_number);
  spdlog::info("stopping");
  application.value()->Stop();
  return kStarted;
}

}  // namespace faultlab::server

#include "server/app/application.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <boost/json/serialize.hpp>
#include <filesystem>
#include <thread>
#include <utility>

#include "hardware/lcm/rig_finder.h"
#include "server/app/camera_rigs.h"
#include "server/app/job_places.h"
#include "server/app/lcm_run_tap.h"
#include "server/app/local_rigs.h"
#include "server/app/member_address.h"
#include "server/app/private_folder.h"
#include "server/app/services.h"
#include "server/app/static_files.h"
#include "server/auth/accounts.h"
#include "server/camera/camera_reader.h"
#include "server/camera/picture_taker.h"
#include "server/diagnosis_json/calibration_json.h"
#include "server/disk_ballast.h"
#include "server/experiment/baseline.h"
#include "server/lab/lab_id.h"
#include "server/plots/record_figure.h"
#include "server/run/rig_pool.h"
#include "server/storage/database.h"
#include "server/storage/database_check.h"
#include "server/storage/folder_lock.h"
#include "server/storage/picture_store.h"
#include "server/storage/postgres_location.h"
#include "server/storage/rig_calibrations.h"
#include "server/stream/stream_tokens.h"

namespace faultlab::server {
namespace {

std::string DatabaseLocation(const Config& config) {
  if (!config.database_url.empty()) return config.database_url;
  return (std::filesystem::path(config.data_dir) / "faultlab.db").string();
}

/// Beside the database file, with links followed; a server on PostgreSQL locks its data folder.
std::string LockFile(const Config& config) {
  const std::string location = DatabaseLocation(config);
  if (IsPostgres(location) || location.find("://") != std::string::npos) {
    return (std::filesystem::path(config.data_dir) / "faultlab.lock").string();
  }
  std::error_code ec;
  const std::filesystem::path file = std::filesystem::weakly_canonical(location, ec);
  if (ec) return location + ".lock";
  if (std::filesystem::hard_link_count(file, ec) > 1 && !ec) {
    spdlog::warn(
        "{} has a second name (a hard link): a server started by that name would not see this one, "
        "and both would damage the database",
        file.string());
  }
  return file.string() + ".lock";
}

RigStatus StatusOf(const hardware::RemoteRigInfo& info) {
  RigStatus status;
  status.description = info.description;
  status.profile = info.description.profile;
  status.state =
      info.link == hardware::LinkState::kLost ? hardware::RigState::kOffline : info.state;
  status.remote = info;
  return status;
}

GuestAccess ToGuestAccess(const std::string& from) {
  if (from == "everywhere") return GuestAccess::kEverywhere;
  return from == "loopback" ? GuestAccess::kLoopback : GuestAccess::kNever;
}

}  // namespace

/// Everything that lives as long as the server, in the order of construction.
class Application::Impl {
 public:
  Impl(const Config& config,
       std::vector<LocalBench> local_benches,
       FolderLock lock,
       std::unique_ptr<Database> database,
       const Clock& clock)
      : config_(config),
        local_benches_(std::move(local_benches)),
        lock_(std::move(lock)),
        clock_(clock),
        database_(std::move(database)),
        store_(*database_),
        calibrations_(*database_),
        benches_(*database_, BenchesOf(local_benches_)),
        hub_(HubOptions(config), clock_),
        tokens_(clock_, config.server_id),
        ballast_(BallastDisk(config), [](std::string_view text) { spdlog::error("{}", text); }),
        accounts_(*database_, ToGuestAccess(config.guests)),
        cameras_(
            config.cameras, clock_, {}, [](std::string_view text) { spdlog::warn("{}", text); }),
        pictures_(*database_),
        picture_taker_(TakerParts()),
        runs_(RunOptions(config), store_, hub_, clock_, [](std::string_view text) {
          spdlog::warn("{}", text);
        }) {
    AddLocalRigs(rig_pool_, config, local_benches_);
    http_ = std::make_unique<HttpServer>(
        NetOptions(config), router_, [this](const HttpRequest& request) {
          return services_->DecideUpgrade(request);
        });
  }

  /// The address is bound before stored data is changed: a server that cannot serve must not mark,
  /// end or recover anything that another server may be using.
  core::Status Start() {
    TRY_DONE(CheckCameraRigs(config_, rig_pool_));
    TRY_DONE(http_->Bind());
    TRY_DONE(benches_.NameOlderRecordings(clock_.Wall()));
    if (!config_.lcm_url.empty()) {
      TRY(tap_, OpenLcmRunTap(config_.lcm_url));
      runs_.SetTap(tap_.get());
      TRY_DONE(FindRemoteRigs());
    }
    TRY_DONE(hub_.Start());
    TRY(auto secret, lab::HopSecret(*database_));
    http_->SetHopSeal(ForwardingSeal(secret, config_.server_id));
    TRY_DONE(OpenServices());
    const core::Status listening = http_->Start();
    return listening.ok() ? OfferFirstLink() : listening;
  }

  void Stop() {
    if (std::exchange(stopped_, true)) return;
    http_->Stop();
    if (services_) services_->Stop();
    runs_.Shutdown();
    picture_taker_.Stop();
    hub_.Stop();
  }

  RunManager& runs() { return runs_; }
  RecordingStore& store() { return store_; }
  StreamHub& hub() { return hub_; }
  const HttpServer& http() const { return *http_; }
  const Router& router() const { return router_; }

 private:
  core::Status OpenServices() {
    Services::Options options;
    options.server_id = config_.server_id;
    TRY(options.address, MemberAddress(config_, http_->address()));
    options.speed = config_.sim_speed;
    const int cores = static_cast<int>(std::thread::hardware_concurrency());
    options.job_places = PlacesForJobs(Simulators(), std::max(1, cores));
    options.needs_no_turn = {config_.short_samples_max, config_.short_text_bytes_max};
    options.default_seed = config_.fixture_seed;
    options.openapi = EmbeddedOpenApi();
    options.http_counters = [this] { return http_->counters(); };
    options.retention = {config_.keep_guest_days,
                         config_.keep_student_days,
                         config_.keep_job_days,
                         config_.keep_news_days};
    options.places = {config_.runs_max,
                      config_.runs_per_caller_max,
                      std::max(1, Simulators() / 2),
                      std::max(1, Simulators() / 2),
                      config_.replayed_samples_max};
    // Where time is faster, so are people who wait for their runs.
    options.places.starts_per_s = std::max(1.0, config_.sim_speed);
    options.storage = {config_.samples_per_account, config_.samples_of_guests, Disk()};
    options.disk_check = [this] { return ballast_.Check(); };
    options.log = [](std::string_view text) { spdlog::warn("{}", text); };
    options.find_far_rig = [this](const std::string& id) -> std::shared_ptr<hardware::Rig> {
      return finder_ != nullptr ? finder_->Find(id) : nullptr;
    };
    options.news.reminders.clear();
    for (const int each : config_.reminders_min) options.news.reminders.emplace_back(each);
    options.webhooks_insecure_local = config_.webhooks_insecure_local;
    options.webhooks_ca_file = config_.webhooks_ca_file;
    options.platforms = {config_.lti_ca_file, config_.lti_insecure_loopback};
    options.mail = config_.mail;
    options.providers = config_.providers;
    options.public_url = config_.public_url;
    TRY(options.login_secret, lab::LoginSecret(*database_));
    TRY(services_,
        Services::Open({*database_,
                        store_,
                        calibrations_,
                        benches_,
                        rig_pool_,
                        hub_,
                        tokens_,
                        accounts_,
                        runs_,
                        cameras_,
                        pictures_,
                        clock_},
                       std::move(options),
                       router_));
    AddStaticRoutes(router_, EmbeddedFiles());
    return core::Done{};
  }
  /// There is no default password: while there is no admin, the log contains a link that makes one.
  core::Status OfferFirstLink() {
    TRY(const auto link, accounts_.FirstStartLink(config_.server_id, clock_.Wall()));
    if (!link) return core::Done{};
    if (!link->secret.empty()) {
      spdlog::warn(
          "no admin yet: set the password of 'admin' within 24 h at http://{}/reset?token={}",
          http_->address(),
          link->secret);
      return core::Done{};
    }
    const std::string& maker = link->made_by;
    spdlog::warn(
        "no admin yet: a link that sets the password of 'admin' was made {} and is still good; "
        "`faultlab admin users link admin` makes another and ends that one",
        maker.empty() ? "by `faultlab admin`" : "by server " + maker + ", whose log has it");
    return core::Done{};
  }
  core::Status FindRemoteRigs() {
    hardware::RigFinderOptions options;
    options.lcm_url = config_.lcm_url;
    options.key_directory = config_.lcm_keys;
    options.server_name = config_.server_id;
    TRY(options.lab, lab::LabId(*database_));
    TRY(finder_, hardware::OpenRigFinder(options));
    rig_pool_.SetFinder([this] {
      std::vector<RigPool::Found> found;
      for (const hardware::RemoteRigInfo& info : finder_->List()) {
        found.push_back(
            {StatusOf(info), [this, id = info.description.id] { return finder_->Find(id); }});
      }
      return found;
    });
    rig_pool_.SetUnprovenRigs([this] {
      std::vector<RigStatus> strangers;
      for (const hardware::RemoteRigInfo& info : finder_->Unkeyed()) {
        strangers.push_back(StatusOf(info));
      }
      return strangers;
    });
    return core::Done{};
  }
  static std::vector<const core::Bench*> BenchesOf(const std::vector<LocalBench>& local) {
    std::vector<const core::Bench*> benches;
    for (const LocalBench& each : local) benches.push_back(each.bench);
    return benches;
  }
  int Simulators() const {
    int count = 0;
    for (const LocalBench& each : local_benches_) count += each.settings.simulators;
    return count;
  }
  static StreamHubOptions HubOptions(const Config& config) {
    StreamHubOptions options;
    options.viewers_max = static_cast<std::size_t>(config.viewers_max);
    return options;
  }
  RunManagerOptions RunOptions(const Config& config) {
    return {config.server_id,
            config.sim_speed,
            AddModelFits,
            [this](const LearntRig& learnt) {
              const WallTime now = clock_.Wall();
              core::Calibration calibration = learnt.calibration;
              calibration.dated = Iso8601(now);
              const InputRange input = RangeOf(learnt.uc_v);
              const core::Status kept = calibrations_.Add(
                  {learnt.rig,
                   learnt.run,
                   learnt.bench.id,
                   now,
                   boost::json::serialize(ToJson(calibration, learnt.bench)),
                   input,
                   WhyNoBaseline(learnt.owner, input, calibration, learnt.bench)});
              if (!kept.ok()) spdlog::warn("rig {}: {}", learnt.rig, kept.error().message);
            },
            [this](const RunMoment& moment) {
              picture_taker_.Note({moment.run, moment.rig, moment.index, std::string(moment.why)});
            },
            (std::filesystem::path(config.data_dir) / "faultlab.backlog").string(),
            [this] { return ballast_.CheckForRecording(); }};
  }
  DiskReserve Disk() const {
    return {config_.data_dir, static_cast<std::int64_t>(config_.disk_reserve_mb) << 20};
  }
  /// A database server has a disk of its own.
  DiskReserve BallastDisk(const Config& config) const {
    if (database_->engine() != Engine::kSqlite) return {};
    return {config.data_dir, static_cast<std::int64_t>(config.disk_reserve_mb) << 20};
  }
  PictureTaker::Parts TakerParts() {
    return {cameras_,
            pictures_,
            clock_,
            Disk(),
            [this](const PictureMoment& moment) {
              const std::vector<RunSnapshot> running = runs_.Running();
              return std::ranges::none_of(running, [&](const RunSnapshot& run) {
                return run.id != moment.run && run.rig == moment.rig && run.on_rig;
              });
            },
            [](std::string_view text) { spdlog::warn("{}", text); }};
  }
  static HttpServerOptions NetOptions(const Config& config) {
    HttpServerOptions options;
    options.listen = config.listen;
    options.allowed_hosts = config.allowed_hosts;
    options.trusted_proxies = config.trusted_proxies;
    options.limits.connections_max = static_cast<std::size_t>(config.connections_max);
    options.limits.pool.threads = config.pool_threads;
    options.limits.peers.tunnels_max = static_cast<std::size_t>(config.viewers_max);
    options.on_error = [](std::string_view text) { spdlog::error("{}", text); };
    return options;
  }

  const Config config_;
  const std::vector<LocalBench> local_benches_;
  const FolderLock lock_;
  bool stopped_ = false;
  const Clock& clock_;
  std::unique_ptr<Database> database_;
  RecordingStore store_;
  RigCalibrations calibrations_;
  Benches benches_;
  std::unique_ptr<hardware::RigFinder> finder_;
  RigPool rig_pool_;
  std::unique_ptr<RunTap> tap_;
  StreamHub hub_;
  StreamTokens tokens_;
  DiskBallast ballast_;
  Accounts accounts_;
  CameraReader cameras_;
  PictureStore pictures_;
  PictureTaker picture_taker_;
  RunManager runs_;
  Router router_;
  std::unique_ptr<Services> services_;
  std::unique_ptr<HttpServer> http_;
};

core::Result<std::unique_ptr<Application>> Application::Open(const Config& config,
                                                             const Clock& clock) {
  TRY(auto benches, LoadLocalBenches(config));
  TRY_DONE(
      MakePrivateFolder(config.data_dir, [](std::string_view text) { spdlog::warn("{}", text); }));
  TRY(auto lock, FolderLock::Take(LockFile(config)));
  DatabaseOptions options;
  options.location = DatabaseLocation(config);
  options.on_error = [](std::string_view text) { spdlog::error("{}", text); };
  TRY(auto database, Database::Open(std::move(options)));
  // PostgreSQL checks itself; reading a whole cluster at each start would take too long.
  if (database->engine() == Engine::kSqlite) {
    TRY_DONE(CheckDatabase(*database));
  }
  auto impl = std::make_unique<Impl>(
      config, std::move(benches), std::move(lock), std::move(database), clock);
  TRY_DONE(impl->Start());
  return std::unique_ptr<Application>(new Application(std::move(impl)));
}

Application::Application(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

Application::~Application() {
  Stop();
}

void Application::Stop() {
  impl_->Stop();
}

std::string Application::address() const {
  return impl_->http().address();
}

int Application::port() const {
  return impl_->http().port();
}

const Router& Application::router() const {
  return impl_->router();
}

RunManager& Application::runs() {
  return impl_->runs();
}

RecordingStore& Application::store() {
  return impl_->store();
}

StreamHub& Application::hub() {
  return impl_->hub();
}

}  // namespace faultlab::server

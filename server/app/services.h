#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/api/api.h"
#include "server/api/gate.h"
#include "server/api/sharing/person_feed.h"
#include "server/app/daily_retention.h"
#include "server/app/doorbell.h"
#include "server/app/job_places.h"
#include "server/app/job_runner.h"
#include "server/app/recovery_service.h"
#include "server/app/rig_watch.h"
#include "server/app/viewer_watch.h"
#include "server/auth/audit_log.h"
#include "server/auth/calendar_links.h"
#include "server/course/exam_room.h"
#include "server/experiment/experiments.h"
#include "server/fault_sets/fault_sets.h"
#include "server/jobs/job_store.h"
#include "server/lab/alarms.h"
#include "server/lab/check_log.h"
#include "server/lab/lab_service.h"
#include "server/lab/relay_wear.h"
#include "server/lab/rig_bands.h"
#include "server/lti/grade_sender.h"
#include "server/lti/launch_flow.h"
#include "server/lti/platform_client.h"
#include "server/lti/platforms.h"
#include "server/lti/registration.h"
#include "server/lti/rosters.h"
#include "server/lti/seats.h"
#include "server/lti/tool_key.h"
#include "server/mail/class_mail.h"
#include "server/notify/dispatcher.h"
#include "server/notify/hook_sender.h"
#include "server/notify/news.h"
#include "server/notify/webhooks.h"
#include "server/storage/database_health.h"
#include "server/upkeep/rig_upkeep.h"

namespace faultlab::server {

/// The parts that serve requests and run the lab, in the order of construction: each member uses
/// those above it. Made when the address is bound; the router then has the routes.
class Services {
 public:
  /// The parts made before; all of them outlive the services.
  struct Base {
    Database& database;
    RecordingStore& store;
    RigCalibrations& calibrations;
    Benches& benches;
    RigPool& rig_pool;
    StreamHub& hub;
    StreamTokens& tokens;
    Accounts& accounts;
    RunManager& runs;
    CameraReader& cameras;
    PictureStore& pictures;
    const Clock& clock;
  };
  struct Options {
    std::string server_id;
    std::string address;  ///< "host:port", for the other members of this database
    double speed = 1.0;   ///< of replays
    JobPlaces job_places;
    LongTurn::Short needs_no_turn{};
    std::optional<std::uint64_t> default_seed;
    std::string_view openapi;
    std::function<HttpCounters()> http_counters;
    RetentionRules retention;
    RunQuotaLimits places;
    StorageLimits storage;
    std::vector<oidc::ProviderSettings> providers;
    std::string public_url;
    std::string login_secret;  ///< shared by the servers of this database
    notify::NewsOptions news;
    bool webhooks_insecure_local = false;
    std::string webhooks_ca_file;
    lti::Reach platforms;
    mail::MailSettings mail;
    RecoveryService::FindRig find_far_rig;     ///< null for a rig that is not heard
    std::function<core::Status()> disk_check;  ///< whether the disk is not full, for /readyz
    std::function<void(std::string_view)> log;
  };
  /// Takes the member's lease, ends what a crash cut off, adds the routes to `router`, starts to
  /// work.
  static core::Result<std::unique_ptr<Services>> Open(const Base& base,
                                                      Options options,
                                                      Router& router);
  ~Services();  ///< Stop()
  /// Starts no new checks and jobs; waits for those in progress. To be called before
  /// RunManager::Shutdown.
  void Stop();

  /// Decides about GET /ws?code=..
  UpgradeDecision DecideUpgrade(const HttpRequest& request) {
    return gate_->DecideUpgrade(request);
  }

 private:
  Services(const Base& base, Options options);
  core::Status MeetPlatforms();
  core::Status JoinLab();
  bool IsOursToRecover(const RunRecord& record) const;
  void BuildApi(Router& router);

  const Base base_;
  const Options options_;
  Doorbell job_bell_;
  JobStore jobs_;
  FaultSets fault_sets_;
  course::Assignments assignments_;
  course::Trials trials_;
  course::Groups groups_;
  IdempotencyStore answers_;
  lab::RigBands bands_;
  lab::CheckLog check_log_;
  lab::RelayWear relay_wear_;
  lab::Alarms alarms_;
  CalendarLinks calendar_links_;
  AuditLog audit_;
  FaultSetAccess fault_set_access_;
  Recordings recordings_;
  RunQuota places_;
  StorageQuota quota_;
  DatabaseHealth health_;
  notify::Webhooks webhooks_;
  notify::HookSender hook_sender_;
  lti::Platforms platforms_;
  lti::Seats seats_;
  std::optional<lti::ToolKey> tool_key_;
  std::unique_ptr<lti::PlatformClient> platform_client_;
  std::unique_ptr<lti::Registration> registration_;
  std::unique_ptr<lti::Rosters> rosters_;
  std::unique_ptr<lti::LaunchFlow> launches_;
  std::unique_ptr<lti::GradeSender> grade_sender_;
  std::unique_ptr<mail::ClassMail> class_mail_;
  RecoveryService rests_;
  RigUpkeep upkeep_;
  std::unique_ptr<lab::LabService> service_;
  std::unique_ptr<RigAccess> rig_access_;
  std::unique_ptr<Experiments> experiments_;
  std::unique_ptr<course::BlindTrials> blind_trials_;
  std::unique_ptr<course::ExamRoom> exam_room_;
  std::unique_ptr<oidc::SignInFlow> sign_in_flow_;
  std::unique_ptr<Api> api_;
  std::unique_ptr<PersonFeed> feed_;
  std::unique_ptr<RequestRouting> whereabouts_;
  std::unique_ptr<Gate> gate_;
  std::unique_ptr<JobRunner> job_runner_;
  std::unique_ptr<RigWatch> rig_watch_;
  std::unique_ptr<DailyRetention> retention_;
  std::unique_ptr<ViewerWatch> viewer_watch_;
  std::unique_ptr<notify::Dispatcher> dispatcher_;
};

}  // namespace faultlab::server

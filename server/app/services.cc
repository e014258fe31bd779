#include "server/app/services.h"

#include <utility>

#include "server/api/routes.h"
#include "server/course/copies.h"
#include "server/storage/owner_key.h"

namespace faultlab::server {

using std::chrono::seconds;

Services::Services(const Base& base, Options options)
    : base_(base),
      options_(std::move(options)),
      jobs_(base.database),
      fault_sets_(base.database),
      assignments_(base.database),
      trials_(base.database),
      groups_(base.database),
      answers_(base.database),
      bands_(base.database),
      check_log_(base.database),
      relay_wear_(base.database),
      alarms_(base.database),
      calendar_links_(base.database),
      audit_(base.accounts, base.clock, options_.log),
      fault_set_access_(fault_sets_, base.accounts),
      recordings_(base.store,
                  base.runs,
                  base.accounts,
                  base.benches,
                  base.clock,
                  options_.needs_no_turn,
                  options_.server_id),
      places_(options_.places),
      quota_(base.store, jobs_, options_.storage),
      health_(base.database, base.clock),
      webhooks_(base.database),
      hook_sender_(options_.webhooks_insecure_local, options_.webhooks_ca_file),
      platforms_(base.database),
      seats_(base.database),
      rests_(base.store, base.clock, options_.find_far_rig, options_.log),
      upkeep_(base.rig_pool, bands_, check_log_, base.benches, base.clock, options_.log) {}

core::Result<std::unique_ptr<Services>> Services::Open(const Base& base,
                                                       Options options,
                                                       Router& router) {
  auto services = std::unique_ptr<Services>(new Services(base, std::move(options)));
  TRY_DONE(services->MeetPlatforms());
  TRY_DONE(services->JoinLab());
  services->BuildApi(router);
  return services;
}

Services::~Services() {
  Stop();
}

void Services::Stop() {
  job_runner_.reset();
  rig_watch_.reset();
  retention_.reset();
  viewer_watch_.reset();
  dispatcher_.reset();
  rests_.Stop();
  upkeep_.Stop();
  base_.rig_pool.SetGate({});
}

core::Status Services::JoinLab() {
  lab::LabServiceOptions options;
  options.member = options_.server_id;
  options.address = options_.address;
  options.alone = base_.database.engine() == Engine::kSqlite;
  options.clock_error_max = seconds(1);
  options.join_patience = options.policy.member_lease + seconds(1);
  options.changed = [this] { job_bell_.Ring(); };
  jobs_.OnAdded([this] { job_bell_.Ring(); });
  TRY(auto service,
      lab::LabService::Open(base_.database, base_.clock, upkeep_, std::move(options)));
  service_ = std::move(service);
  base_.runs.SetGuard([&service = *service_] { return service.InForce(); });
  base_.runs.OnOwnersStop([this](const RunSnapshot& run) {
    Principal owner;
    if (const auto id = AccountOfOwner(run.owner)) {
      const auto account = base_.accounts.Get(*id);
      if (account) owner = PrincipalOf(account.value());
      owner.user_id = *id;
    }
    audit_.AddBounded({owner, "stop_run", "run:" + run.id, "of " + run.owner});
  });
  // From here on this process is the only one with its server_id.
  TRY_DONE(jobs_.Reap(base_.clock.Wall()));
  TRY_DONE(base_.runs.StoreBacklogs());
  rig_access_ = std::make_unique<RigAccess>(*service_, base_.rig_pool, base_.clock, options_.log);
  experiments_ = std::make_unique<Experiments>(Experiments::Parts{base_.runs,
                                                                  base_.store,
                                                                  recordings_,
                                                                  base_.rig_pool,
                                                                  *rig_access_,
                                                                  fault_set_access_,
                                                                  fault_sets_,
                                                                  places_,
                                                                  quota_,
                                                                  base_.benches,
                                                                  base_.calibrations,
                                                                  check_log_,
                                                                  base_.clock,
                                                                  options_.default_seed,
                                                                  SecretNumber,
                                                                  options_.speed});
  recordings_.ShareTrials([this](std::int64_t trial, std::int64_t account) {
    const auto is_of = trials_.IsOf(trial, account);
    return is_of.ok() && is_of.value();
  });
  const auto ended_by_user = [&database = base_.database](lab::SessionId session) {
    const auto ended = database.Read([&](Transaction& tx) -> core::Result<bool> {
      using enum lab::EndReason;
      const lab::EndReason reason = lab::lab_store::EndReasonOf(tx, session);
      if (reason == kExpired) return !lab::lab_store::WasShortened(tx, session);
      return reason == kEnded || reason == kIdle || reason == kBooking;
    });
    return ended.ok() && ended.value();
  };
  const auto settled = [this]() -> core::Result<WallTime> {
    const core::Status looked = service_->TickNow();  // notices a step of the clock
    return looked.ok() ? core::Result<WallTime>(service_->Now()) : looked.error();
  };
  blind_trials_ = std::make_unique<course::BlindTrials>(course::BlindTrials::Parts{assignments_,
                                                                                   trials_,
                                                                                   *experiments_,
                                                                                   recordings_,
                                                                                   base_.store,
                                                                                   base_.benches,
                                                                                   ended_by_user,
                                                                                   base_.clock,
                                                                                   settled,
                                                                                   options_.log});
  recordings_.OpenDueTrials([this](const RunRecord& record) {
    const core::Status looked = blind_trials_->Open(record);
    if (!looked.ok()) options_.log("run " + record.id + ": " + looked.error().message);
  });
  exam_room_ = std::make_unique<course::ExamRoom>(course::ExamRoom::Parts{assignments_,
                                                                          trials_,
                                                                          *blind_trials_,
                                                                          base_.accounts,
                                                                          base_.store,
                                                                          base_.clock,
                                                                          options_.log});
  recordings_.LetWatch({
      .may_bring = [this](const Principal& who) { return exam_room_->MayBring(who); },
      .trials_of =
          [this](std::span<const core::Sample> brought) { return exam_room_->TrialsOf(brought); },
      .note = [this](
                  std::int64_t trial,
                  const RunRecord& copy) { return trials_.AddCopy(trial, course::CopyText(copy)); },
  });
  rests_.Start([this](const RunRecord& record) { return IsOursToRecover(record); },
               [this](const std::string& rig) {
                 const core::Status ended = service_->Do(
                     [&](lab::Scheduler& lab, WallTime now) { return lab.RenewLease(rig, now); });
                 if (!ended.ok()) options_.log("rig " + rig + ": " + ended.error().message);
               });
  base_.rig_pool.SetGate([this](const std::string& rig, std::chrono::milliseconds patience) {
    return rests_.Await(rig, patience);
  });
  rig_watch_ = std::make_unique<RigWatch>(RigWatch::Parts{*service_,
                                                          base_.rig_pool,
                                                          alarms_,
                                                          relay_wear_,
                                                          options_.storage.disk,
                                                          base_.clock,
                                                          options_.log});
  upkeep_.Start(*service_);
  job_runner_ = std::make_unique<JobRunner>(JobRunner::Parts{jobs_,
                                                             *service_,
                                                             base_.accounts,
                                                             *experiments_,
                                                             recordings_,
                                                             base_.runs,
                                                             base_.store,
                                                             base_.clock,
                                                             job_bell_,
                                                             alarms_},
                                            JobRunner::Options{
                                                .places = options_.job_places,
                                                .log = options_.log,
                                            });
  retention_ = std::make_unique<DailyRetention>(
      base_.database, base_.clock, options_.retention, options_.log);
  viewer_watch_ =
      std::make_unique<ViewerWatch>(base_.accounts, base_.hub, base_.tokens, base_.clock);
  dispatcher_ = std::make_unique<notify::Dispatcher>(
      notify::Dispatcher::Parts{base_.database,
                                *service_,
                                hook_sender_,
                                base_.clock,
                                options_.log,
                                {grade_sender_.get(), class_mail_.get()}},
      options_.news);
  return core::Done{};
}

/// The rig's member reads; while the rig is nobody's, the one that recorded. That one may never
/// come back: after a while each ends what nobody has read.
bool Services::IsOursToRecover(const RunRecord& record) const {
  constexpr auto kLeftToItsMember = std::chrono::minutes(10);
  if (const auto member = service_->MemberOf(record.rig)) return member->id == service_->member();
  if (record.server_id == service_->member()) return true;
  return record.ended_at && base_.clock.Wall() > *record.ended_at + kLeftToItsMember;
}

core::Status Services::MeetPlatforms() {
  TRY(tool_key_, lti::ToolKey::Open(base_.database, base_.clock.Wall()));
  platform_client_ =
      std::make_unique<lti::PlatformClient>(*tool_key_, options_.platforms, base_.clock);
  registration_ =
      std::make_unique<lti::Registration>(options_.login_secret, *platform_client_, base_.clock);
  rosters_ = std::make_unique<lti::Rosters>(base_.database, *platform_client_, base_.clock);
  launches_ = std::make_unique<lti::LaunchFlow>(
      base_.database, options_.login_secret, options_.platforms, *platform_client_, base_.clock);
  grade_sender_ = std::make_unique<lti::GradeSender>(
      base_.database,
      *platform_client_,
      course::TrialKeeper(
          base_.database,
          [this](std::int64_t trial) { return blind_trials_->Look(trial); },
          options_.log,
          base_.clock),
      base_.clock);
  class_mail_ = std::make_unique<mail::ClassMail>(
      base_.database, base_.accounts, options_.mail, options_.public_url, base_.clock);
  return core::Done{};
}

void Services::BuildApi(Router& router) {
  const auto database_check = [this] {
    const core::Status writes = health_.Check();
    return writes.ok() && options_.disk_check ? options_.disk_check() : writes;
  };
  sign_in_flow_ =
      std::make_unique<oidc::SignInFlow>(options_.providers, options_.login_secret, base_.clock);
  api_ = std::unique_ptr<Api>(new Api{
      .accounts = base_.accounts,
      .audit = audit_,
      .sign_in_flow = *sign_in_flow_,
      .service = *service_,
      .rig_pool = base_.rig_pool,
      .rigs = *rig_access_,
      .checks = check_log_,
      .wear = relay_wear_,
      .alarms = alarms_,
      .with_next_check = [this](const std::string& rig,
                                CheckExtra extra) { upkeep_.WithNextCheck(rig, extra); },
      .contacts_of = [this](const std::string& rig) { return upkeep_.ContactsOf(rig); },
      .calendar_links = calendar_links_,
      .experiments = *experiments_,
      .recordings = recordings_,
      .runs = base_.runs,
      .store = base_.store,
      .calibrations = base_.calibrations,
      .benches = base_.benches,
      .places = places_,
      .quota = quota_,
      .spool_disk = options_.storage.disk,
      .cameras = base_.cameras,
      .pictures = base_.pictures,
      .hub = base_.hub,
      .tokens = base_.tokens,
      .fault_sets = fault_sets_,
      .fault_set_access = fault_set_access_,
      .jobs = jobs_,
      .assignments = assignments_,
      .trials = trials_,
      .groups = groups_,
      .blind_trials = *blind_trials_,
      .webhooks = webhooks_,
      .hook_sender = hook_sender_,
      .platforms = platforms_,
      .launches = *launches_,
      .seats = seats_,
      .tool_key = *tool_key_,
      .platform_client = *platform_client_,
      .registration = *registration_,
      .rosters = *rosters_,
      .class_mail = *class_mail_,
      .database = base_.database,
      .clock = base_.clock,
      .database_check = database_check,
      .http_counters = options_.http_counters,
      .log = options_.log,
      .openapi = options_.openapi,
      .public_url = options_.public_url,
      .started = base_.clock.Monotonic(),
  });
  feed_ = std::make_unique<PersonFeed>(*api_);
  api_->feed = feed_.get();
  whereabouts_ = std::make_unique<RequestRouting>(*service_, base_.clock);
  gate_ = std::make_unique<Gate>(Gate::Parts{answers_, *whereabouts_, *api_});
  AddRoutes(*gate_, router);
}

}  // namespace faultlab::server

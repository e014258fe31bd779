#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "hardware/contact_check.h"
#include "server/api/gate.h"
#include "server/auth/accounts.h"
#include "server/auth/audit_log.h"
#include "server/auth/calendar_links.h"
#include "server/auth/throttle.h"
#include "server/camera/camera_reader.h"
#include "server/course/assignments.h"
#include "server/course/blind_trials.h"
#include "server/course/groups.h"
#include "server/course/trials.h"
#include "server/demonstration/detection_study.h"
#include "server/experiment/experiments.h"
#include "server/experiment/fault_set_access.h"
#include "server/fault_sets/fault_sets.h"
#include "server/jobs/job_store.h"
#include "server/lab/alarms.h"
#include "server/lab/check_log.h"
#include "server/lab/lab_service.h"
#include "server/lab/relay_wear.h"
#include "server/lti/launch_flow.h"
#include "server/lti/platform_client.h"
#include "server/lti/platforms.h"
#include "server/lti/registration.h"
#include "server/lti/rosters.h"
#include "server/lti/seats.h"
#include "server/lti/tool_key.h"
#include "server/mail/class_mail.h"
#include "server/notify/hook_sender.h"
#include "server/notify/webhooks.h"
#include "server/oidc/sign_in_flow.h"
#include "server/run/rig_pool.h"
#include "server/run/run_manager.h"
#include "server/storage/picture_store.h"
#include "server/storage/rig_calibrations.h"
#include "server/stream/stream_hub.h"
#include "server/stream/stream_tokens.h"
#include "server/upkeep/check_extra.h"

namespace faultlab::server {

class PersonFeed;

/// What handlers work on: all parts of the server that answer a request. They outlive the routes.
struct Api {
  Accounts& accounts;
  AuditLog& audit;
  oidc::SignInFlow& sign_in_flow;

  lab::LabService& service;
  RigPool& rig_pool;
  RigAccess& rigs;
  lab::CheckLog& checks;
  lab::RelayWear& wear;
  lab::Alarms& alarms;
  /// What the next check of this rig does besides. Then ask for a check.
  std::function<void(const std::string& rig, CheckExtra extra)> with_next_check;
  /// Of this member's checks since it started.
  std::function<std::optional<RigContacts>(const std::string& rig)> contacts_of;
  CalendarLinks& calendar_links;

  Experiments& experiments;
  Recordings& recordings;
  RunManager& runs;
  RecordingStore& store;
  RigCalibrations& calibrations;
  Benches& benches;
  RunQuota& places;
  StorageQuota& quota;
  DiskReserve spool_disk;
  CameraReader& cameras;
  PictureStore& pictures;
  StreamHub& hub;
  StreamTokens& tokens;

  FaultSets& fault_sets;
  FaultSetAccess& fault_set_access;
  JobStore& jobs;
  course::Assignments& assignments;
  course::Trials& trials;
  course::Groups& groups;
  course::BlindTrials& blind_trials;
  notify::Webhooks& webhooks;
  const notify::HookSender& hook_sender;
  lti::Platforms& platforms;
  lti::LaunchFlow& launches;
  lti::Seats& seats;
  const lti::ToolKey& tool_key;
  lti::PlatformClient& platform_client;
  const lti::Registration& registration;
  lti::Rosters& rosters;
  mail::ClassMail& class_mail;

  Database& database;
  const Clock& clock;
  std::function<core::Status()> database_check;  ///< cheap: for /readyz
  std::function<HttpCounters()> http_counters;
  std::function<void(std::string_view)> log;
  std::string_view openapi;  ///< server/api/openapi.json, embedded
  std::string public_url;    ///< "https://lab.example.org"; empty: not known
  MonotonicTime started;

  PersonFeed* feed = nullptr;
  DetectionStudies studies{};
  Throttle failed_callbacks{20};  ///< of sign-in providers, by network: each asked the provider
  Throttle failed_launches{200};  ///< of learning platforms: a class is one network
  Throttle refusal_lines{20};     ///< of their refusals in the log, by network

  /// For an answer that may be large.
  std::unique_ptr<Spool> MakeSpool() const { return std::make_unique<Spool>(spool_disk); }
};

}  // namespace faultlab::server

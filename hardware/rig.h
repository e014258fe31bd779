#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/bench/bench.h"
#include "core/types/component.h"
#include "core/types/result.h"
#include "core/types/sample.h"
#include "hardware/loop_quality.h"
#include "hardware/run_plan.h"

namespace faultlab::hardware {

/// Of a lease, made by the server's lab: rises with every new one. Whatever carries an older epoch
/// is refused here, below everything that could have a bug about who may use the rig.
enum class Epoch : std::uint64_t {};

/// The `field` of an Error of a far rig that does not take the lease: kStale when it has seen a
/// higher epoch than the lease's; else it is to be waited for (another lab holds it, it is not
/// heard, its agent's disk is full).
inline constexpr std::string_view kLeaseField = "lease";

enum class RigKind { kBench, kSimulated, kReplay, kRemote };

/// What a rig is and can do. Fixed while the rig lives.
struct RigDescription {
  std::string id;                      ///< "sim-1"
  std::string rig_class;               ///< interchangeable rigs share it: "bench-sim"
  const core::Bench* bench = nullptr;  ///< what it is built like; never null of a rig
  RigKind kind = RigKind::kSimulated;
  bool has_um = true;
  bool has_ua = true;
  bool has_ia = true;
  bool has_n = true;
  /// Component values the rig accepts. Relay boards take the positions of the bench alone; a
  /// simulator takes any positive value of any component.
  bool any_value = false;
  bool motor_faults = false;    ///< Ra, J, B can be changed (simulators)
  bool controls_speed = false;  ///< it takes plans with SpeedControlPlan
  double uc_v_min = 0.0;
  double uc_v_max = 0.0;
  double delta_s = 0.0;  ///< DAC edge of uc(k) to ADC sample um(k)
  std::string profile;   ///< "bench" or "multisim" for a simulator, empty otherwise
  core::Quadrants amplifier_quadrants = core::Quadrants::kTwo;
};

enum class RigState { kOffline, kIdle, kArmed, kRunning, kStopping, kTripped };

/// "offline", "idle", "armed", "running", "stopping", "tripped".
std::string_view Name(RigState state);
/// "bench", "simulated", "replay", "remote".
std::string_view Name(RigKind kind);

/// An interlock that acted. It latches: the rig refuses to arm until kClearTrip.
struct Trip {
  std::string name;        ///< "over_current", "stall", .. : the table in hardware/README.md
  double value = 0.0;      ///< what was seen, unit by name
  double limit = 0.0;      ///< what it was held against, same unit
  std::int64_t index = 0;  ///< sample of the run
  double t_s = 0.0;        ///< run time
  std::string text;        ///< one sentence for a person
};

enum class RigEventKind {
  kStarted,
  kFaultCommanded,     ///< accepted; acts at `index`
  kRelayConfirmed,     ///< read back from the board (or the plant of a simulator)
  kControlBegan,       ///< the rig keeps its speed from here on
  kCompensated,        ///< the drive makes up for the fault that the order names
  kCompensationEnded,  ///< not any more; `text` says why
  kRefused,            ///< with the reason in `text`
  kTrip,               ///< an interlock acted; `text` names it, `value` is what it saw
  kOverrun,            ///< a tick came late by `value` seconds
  kDeltaStrays,        ///< for a second delta was `value` seconds, which is not the described one
  kGap,                ///< samples [index, index + value) were lost on the way
  kFinished,           ///< the plan was played to its end
  kStopped,            ///< safe stop before the end; `text` says why
};

struct RigEvent {
  RigEventKind kind = RigEventKind::kStarted;
  std::int64_t index = 0;  ///< the sample on which it acted
  core::Component component{};
  /// Of kStopped: seconds from its cause (the request, the last word of a silent holder, the tick
  /// that failed) to drive 0 and nominal relays; 0 where the rig could not be made safe or the link
  /// told of no time.
  double value = 0.0;
  std::string text;
};

/// Text of a kFaultCommanded that a Command caused, not the plan.
inline constexpr std::string_view kLiveText = "live";

/// "started", "fault_commanded", "relay_confirmed", "control_began", "compensated",
/// "compensation_ended", "refused", "trip", "overrun", "delta_strays", "gap", "finished",
/// "stopped": the words of the stream and of recordings.
std::string_view Name(RigEventKind kind);

std::optional<RigEventKind> ParseRigEventKind(std::string_view name);
/// Whether events of this kind are about a component.
bool NamesComponent(RigEventKind kind);

/// What a rig says, in order: samples and events share one stream.
using RigMessage = std::variant<core::Sample, RigEvent>;

struct RigCommand {
  enum class Kind { kSetComponent, kAllNominal, kClearTrip, kControl };
  Kind kind = Kind::kAllNominal;
  core::Component component{};
  double value = 0.0;
  std::optional<core::ControlOrder> control{};  ///< of kControl, which needs a plan of control
};

struct SelfTestPosition {
  core::Component component{};
  double value;
  std::string line;  ///< "Do17"
  bool ok;
  std::string text;
};

struct SelfTestReport {
  std::vector<SelfTestPosition> positions;
  bool ok = false;
};

enum class ReadStatus { kMore, kEnded };

/// One bench, near or far. A rig paces itself (its own thread or process); its holder drains it.
/// Thread-safe: one thread may Read while another commands or stops. Destruction is a safe stop.
class Rig {
 public:
  virtual ~Rig() = default;

  virtual const RigDescription& description() const = 0;
  virtual RigState state() const = 0;

  /// Takes the lease's epoch and the whole plan; refuses a plan outside the envelope by naming
  /// what.
  virtual core::Status Arm(RunPlan plan, Epoch epoch) = 0;
  virtual core::Status Start(Epoch epoch) = 0;
  /// Acts at the next tick; the answering events name the sample.
  virtual core::Status Command(Epoch epoch, const RigCommand& command) = 0;
  /// The holder is alive. Without Command, Read or KeepAlive for 500 ms the rig goes safe by
  /// itself.
  virtual void KeepAlive(Epoch epoch) = 0;
  /// Appends what has come since the last call; waits up to `patience` if that is nothing.
  /// kEnded after the last message of a run.
  virtual ReadStatus Read(std::vector<RigMessage>& out, std::chrono::milliseconds patience) = 0;
  /// Raises the fence: from now on everything with an older epoch is refused, and a run of an
  /// older epoch is stopped. Waits for no network: a far rig stops when it hears of it, or by its
  /// watchdog. An epoch that is not newer changes nothing.
  virtual void Fence(Epoch epoch) = 0;
  /// Drive 0, relays nominal. Never fails upward, may be called at any time, any number of times.
  virtual void SafeStop(std::string_view reason) = 0;
  /// Takes the lease's epoch and walks all relay positions with read-back. kConflict unless
  /// idle. A position that does not answer is in the report; an error says why none was walked.
  virtual core::Result<SelfTestReport> SelfTest(Epoch epoch) = 0;

  /// The interlock that holds the rig in kTripped, if one does.
  virtual std::optional<Trip> trip() const = 0;
  /// Lateness of the loop since the rig was made: for /metrics, and by difference for a recording.
  virtual LoopQuality loop_quality() const = 0;

  /// Since the last word of a far rig; nothing for a rig in this process, which cannot fall silent.
  virtual std::optional<std::chrono::nanoseconds> silence() const { return std::nullopt; }
  /// Names the armed or running run for Resume, in this process or a later one: a far rig keeps the
  /// messages of its newest run. Empty: this rig keeps none.
  virtual std::string kept_run() const { return {}; }
  /// Reads again the run of this name: Read then gives what the rig still has of it, from its first
  /// message to its end. Needs no lease and commands nothing. kNotFound: the rig has the run no
  /// longer (it began another one, or started anew); kUnavailable: it is not heard; kConflict: a
  /// run is read already.
  virtual core::Status Resume(const std::string& kept_run);
};

}  // namespace faultlab::hardware

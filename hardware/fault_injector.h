#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/plant/fault_schedule.h"
#include "hardware/relay_board.h"
#include "hardware/rig.h"
#include "hardware/simulator_port.h"

namespace faultlab::hardware {

/// Decides at each tick which component is to have which value: the plan's schedule, live commands
/// on top, relay boards resting between two switchings. Says what it does as events.
/// Table values go to the relay board, others to the simulator's port.
class FaultInjector {
 public:
  /// @param port  null on a bench; relays and port must outlive this
  FaultInjector(const RigDescription& description,
                double relay_rest_s,
                RelayBoard& relays,
                SimulatorPort* port);

  core::Status Check(const RunPlan& plan) const;
  core::Status Check(const RigCommand& command) const;

  void Begin(const RunPlan& plan);
  /// Takes live commands; the newest for a component wins, the one before it is told so.
  void Accept(std::span<const RigCommand> commands,
              std::int64_t index,
              std::vector<RigMessage>& out);
  /// Does what is due at the sample: requests relay positions, sets the port, announces.
  void Act(std::int64_t index, double t_s, std::vector<RigMessage>& out);
  /// The relays have been read back: confirms what Act announced.
  void Confirm(std::int64_t index, std::vector<RigMessage>& out);

 private:
  struct Part {
    bool scheduled = false;      ///< the plan has faults of it
    double scheduled_value = 0;  ///< last value of the schedule
    std::optional<double> wanted;
    bool live = false;       ///< `wanted` is a live command
    bool drifting = false;   ///< announced; follows the schedule quietly
    bool overruled = false;  ///< a live command ended the drift under way
    bool off_table = false;
    double switched_at_s = -1e9;
    std::optional<double> unconfirmed;
  };

  core::Status CheckValue(core::Component component, double value, const std::string& field) const;
  const core::Fault* DriftAt(core::Component component, double t_s) const;
  void Follow(core::Component component,
              std::int64_t index,
              double t_s,
              std::vector<RigMessage>& out);
  double NominalOf(core::Component component) const {
    return description_.bench->nominal.Get(component);
  }
  void Want(core::Component component, double value, bool live);
  Part& part(core::Component component) {
    return parts_[static_cast<std::size_t>(core::Index(component))];
  }

  const RigDescription& description_;
  const double relay_rest_s_;
  RelayBoard& relays_;
  SimulatorPort* const port_;
  std::vector<core::Fault> faults_;
  std::optional<core::FaultSchedule> schedule_;
  std::array<Part, core::kComponentsMax> parts_;
};

}  // namespace faultlab::hardware

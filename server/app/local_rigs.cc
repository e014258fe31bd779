#include "server/app/local_rigs.h"

#include <memory>
#include <set>
#include <string>
#include <utility>

#include "hardware/bench/benches.h"
#include "hardware/simulated/simulated_rig.h"

namespace faultlab::server {
namespace {

/// Servers that share a database share the names of its rigs.
std::string RigName(const Config& config, const std::string& kind, int number) {
  const std::string prefix = config.server_id == Config{}.server_id ? "" : config.server_id + "-";
  return prefix + kind + std::to_string(number);
}

hardware::SimulatedRigOptions OptionsOf(const Config& config, const LocalBench& local) {
  hardware::SimulatedRigOptions options;
  options.bench = local.bench;
  options.speed = config.sim_speed;
  options.profile = local.settings.profile;
  return options;
}

void AddSimulators(RigPool& rig_pool,
                   const Config& config,
                   const LocalBench& local,
                   const std::string& kind) {
  for (int i = 1; i <= local.settings.simulators; ++i) {
    hardware::SimulatedRigOptions options = OptionsOf(config, local);
    options.id = RigName(config, kind, i);
    options.rig_class = local.bench->rig_class + "-sim";
    const hardware::RigDescription description = hardware::MakeSimulatedRig(options)->description();
    const auto make = [options](double speed) {
      hardware::SimulatedRigOptions at = options;
      at.speed = speed;
      return [at] { return std::shared_ptr<hardware::Rig>(hardware::MakeSimulatedRig(at)); };
    };
    rig_pool.Add(description, description.profile, make(config.sim_speed), make(0.0));
  }
}

void AddStandIns(RigPool& rig_pool,
                 const Config& config,
                 const LocalBench& local,
                 const std::string& kind) {
  for (int i = 1; i <= local.settings.lab; ++i) {
    hardware::SimulatedRigOptions options = OptionsOf(config, local);
    options.id = RigName(config, kind, i);
    options.profile.clear();
    options.rig_class = local.bench->rig_class;
    options.kind = hardware::RigKind::kBench;
    std::shared_ptr<hardware::Rig> rig = hardware::MakeSimulatedRig(options);
    const std::string profile = rig->description().profile;
    rig_pool.AddResident(std::move(rig), profile);
  }
}

}  // namespace

core::Result<std::vector<LocalBench>> LoadLocalBenches(const Config& config) {
  std::vector<BenchSettings> wanted = config.benches;
  if (wanted.empty()) {
    wanted.push_back({"", config.sim_rigs, config.sim_profile, config.lab_benches});
  }
  std::vector<LocalBench> benches;
  std::set<std::string> names;
  for (BenchSettings& settings : wanted) {
    TRY(const auto bench, hardware::LoadBench(settings.file));
    if (!names.insert(bench->name).second) {
      return core::Error{core::ErrorCode::kInvalid,
                         settings.file + ": a bench named '" + bench->name +
                             "' is given twice; change `name` in one of the files",
                         "bench"};
    }
    TRY_DONE(hardware::FindProfile(*bench, settings.profile));
    benches.push_back({bench, std::move(settings)});
  }
  return benches;
}

void AddLocalRigs(RigPool& rig_pool, const Config& config, const std::vector<LocalBench>& benches) {
  for (const LocalBench& local : benches) {
    const std::string prefix = &local == &benches.front() ? "" : local.bench->name + "-";
    AddSimulators(rig_pool, config, local, prefix + "sim-");
    AddStandIns(rig_pool, config, local, prefix + "bench-");
  }
}

}  // namespace faultlab::server

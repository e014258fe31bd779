// The contract of a Rig, kept by the boards' drivers with the stand-ins of their libraries.
#include <atomic>
#include <memory>
#include <string>

#include "hardware/config/bench_file.h"
#include "hardware/daq/shared_library.h"
#include "hardware/paced_rig.h"
#include "hardware/rig_machine.h"
#include "tests/hardware/rig_contract.h"
#include "tests/hardware/stand_in.h"
#include "tests/support/paths.h"

namespace faultlab::hardware {
namespace {

/// Time of a rig and of the plant behind its terminals, which a safe stop asks from other threads.
class PlantClock final : public Clock {
 public:
  explicit PlantClock(StandInControl& control) : control_(control) {}
  Nanoseconds Now() const override { return inner_->Now(); }
  Wake SleepUntil(Nanoseconds deadline) override {
    const Wake wake = inner_->SleepUntil(deadline);
    std::atomic_ref(control_.now_ns).store(Now().count());
    return wake;
  }

 private:
  StandInControl& control_;
  const std::shared_ptr<Clock> inner_ = MakeSimulatedClock(0.0, Nanoseconds(0));
};

struct Board {
  std::string library;
  std::string config;
  StandInScans scans = StandInScans::kNone;
};

/// The stand-in of the rig that the test has, kept loaded.
std::unique_ptr<SharedLibrary> the_library;

/// Each run has its motor at rest and its noise from the beginning.
class FreshPlant final : public RigMachine {
 public:
  FreshPlant(std::unique_ptr<RigMachine> machine, StandInControl& control)
      : machine_(std::move(machine)), control_(control) {}

  const RigDescription& description() const override { return machine_->description(); }
  core::Status Check(const RunPlan& plan) const override { return machine_->Check(plan); }
  core::Status Check(const RigCommand& command) const override { return machine_->Check(command); }
  void Prepare(const RunPlan& plan) override {
    control_.begin_run = true;
    machine_->Prepare(plan);
  }
  std::optional<Nanoseconds> Step(const StepTime& time,
                                  std::span<const RigCommand> commands,
                                  std::vector<RigMessage>& out) override {
    return machine_->Step(time, commands, out);
  }
  std::string MakeSafe() noexcept override { return machine_->MakeSafe(); }
  SelfTestReport SelfTest() override { return machine_->SelfTest(); }
  std::optional<Trip> trip() const override { return machine_->trip(); }
  void ClearTrip() override { machine_->ClearTrip(); }

 private:
  const std::unique_ptr<RigMachine> machine_;
  StandInControl& control_;
};

std::unique_ptr<Rig> MakeBoard(const Board& board) {
  the_library = std::make_unique<SharedLibrary>(board.library);
  StandInControlFunction* function = nullptr;
  the_library->Find("stand_in_control", function);
  StandInControl& control = *function();
  control = StandInControl{};
  control.scans = board.scans;
  core::Result<BenchFile> file = ParseBenchFile(board.config, "bench.toml");
  if (!file.ok()) throw std::logic_error(file.error().message);
  BenchFile bench = std::move(file).value();
  bench.driver_patience = std::chrono::seconds(10);  // a busy machine is not a hanging driver
  const auto clock = std::make_shared<PlantClock>(control);
  return std::make_unique<PacedRig>(
      std::make_unique<FreshPlant>(OpenMachine(bench, MakeSimulatedClock(0.0, Nanoseconds(0))),
                                   control),
      PacedRigOptions{.clock = clock,
                      .wall = MakeSteadyClock(),
                      .wait_for_reader = true,
                      .watchdog = Nanoseconds(0)});
}

Board Ni(const std::string& keys, const std::string& more = "") {
  return {tests::InBuild("tests/hardware/libstand_in_nidaqmx.so"),
          std::string("driver = \"nidaqmx\"\n[nidaqmx]\nlibrary = \"") +
              tests::InBuild("tests/hardware/libstand_in_nidaqmx.so") + "\"\n" + keys + more};
}

Board Comedi(const std::string& keys, StandInScans scans) {
  return {tests::InBuild("tests/hardware/libstand_in_comedi.so"),
          std::string("driver = \"comedi\"\n[comedi]\nlibrary = \"") +
              tests::InBuild("tests/hardware/libstand_in_comedi.so") +
              "\"\nreference = \"diff\"\ncounter = 3\n" + keys,
          scans};
}

RunPlan Plan() {
  return SquarePlan(kSamples);
}

const RigUnderContract kBoards[] = {
    {"NiFrequency", [] { return MakeBoard(Ni("")); }, Plan},
    {"NiCount", [] { return MakeBoard(Ni("", "[encoder]\nmethod = \"count\"\n")); }, Plan},
    {"NiQuadrature", [] { return MakeBoard(Ni("counts = \"quadrature\"\n")); }, Plan},
    {"NiWithItsWatchdog", [] { return MakeBoard(Ni("watchdog = \"cRIO1\"\n")); }, Plan},
    {"ComediSingleReads", [] { return MakeBoard(Comedi("", StandInScans::kNone)); }, Plan},
    {"ComediBothWays",
     [] { return MakeBoard(Comedi("counts = \"both\"\n", StandInScans::kNone)); },
     Plan},
    {"ComediClocked", [] { return MakeBoard(Comedi("", StandInScans::kAtOnce)); }, Plan},
};

INSTANTIATE_TEST_SUITE_P(Boards, RigContract, testing::ValuesIn(kBoards), NameOfKind);

}  // namespace
}  // namespace faultlab::hardware

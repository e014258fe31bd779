#include "core/control/speed_model.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/control/closed_loop/orders.h"
#include "core/control/compensation_check.h"
#include "core/control/speed_controller.h"
#include "core/control/tolerant_drive.h"
#include "core/control/virtual_actuator.h"
#include "core/filter/rig_parameters.h"
#include "core/plant/sampled_model.h"
#include "core/signals/random.h"
#include "hardware/bench/benches.h"

namespace faultlab::core {
namespace {

constexpr double kPeriodS = 0.01;

RigParameters RigOf(const Bench& bench) {
  return {bench.nominal, 1.0, bench.delta_s, bench.norm.mc_nm, 1e-4};
}

TEST(SpeedModel, IsTheExactModelButForTheInductance) {
  for (const char* name : {"paper", "gear-motor", "speed-motor"}) {
    const Bench& bench = *hardware::LoadBench(name).value();
    const RigParameters rig = RigOf(bench);
    const SpeedModel model = SpeedModelOf(rig, kPeriodS);
    const SampledModel exact = MakeSampledModel(rig.plant, kPeriodS, 0.0);
    Eigen::Vector3d x = exact.SteadyState(2.0, rig.mc_nm);
    EXPECT_NEAR(model.Settled(2.0), x(2), 1e-6 * x(2)) << name;
    double w = x(2);
    for (int k = 0; k < 5; ++k) {
      x = exact.phi * x + exact.gamma_u * 3.0 + exact.gamma_m * rig.mc_nm;
      w = model.Next(w, 3.0);
    }
    EXPECT_NEAR(w, x(2), 0.02 * x(2)) << name;
    EXPECT_NEAR(model.InputFor(w, model.Next(w, 2.7)), 2.7, 1e-9) << name;
  }
}

TEST(SpeedModel, SaysWhatADitherCosts) {
  const SpeedModel model{.kept = 0.6, .gain = 60.0, .friction = 5.0};
  double w = model.Settled(2.5);
  const double mean = w;
  double squares = 0.0;
  constexpr int kTicks = 4000;
  for (int k = 0; k < 2 * kTicks; ++k) {
    w = model.Next(w, 2.5 + ((k / 2) % 2 == 0 ? 0.1 : -0.1));
    if (k >= kTicks) squares += (w - mean) * (w - mean);
  }
  EXPECT_NEAR(std::sqrt(squares / kTicks), 0.1 * model.RipplePerVolt(), 1e-6);
}

TEST(VirtualActuator, MakesAFaultyRigMoveAsTheHealthyOne) {
  const SpeedModel healthy{.kept = 0.6, .gain = 60.0, .friction = 5.0};
  const SpeedModel faulty{.kept = 0.8, .gain = 40.0, .friction = 9.0};
  VirtualActuator actuator(healthy);
  EXPECT_EQ(actuator.RigInput(2.5, 100.0, 0.0), 2.5) << "without a fault";
  actuator.Reconfigure(LaggedModel{.motor = faulty});
  double w = 100.0;
  for (const double v : {2.5, 3.0, 2.0, 2.8}) {
    const double u = actuator.RigInput(v, w, 0.0);
    EXPECT_NEAR(actuator.ControllerInput(u, w, 0.0), v, 1e-9);
    EXPECT_NEAR(faulty.Next(w, u), healthy.Next(w, v), 1e-9);
    w = faulty.Next(w, u);
  }
  actuator.Withdraw();
  EXPECT_EQ(actuator.RigInput(2.5, w, 0.0), 2.5) << "withdrawn";
}

TEST(VirtualActuator, MakesUpForAnAmplifiersLag) {
  const SpeedModel healthy{.kept = 0.6, .gain = 60.0, .friction = 5.0};
  const LaggedModel slow{
      .motor = {.kept = 0.6, .gain = 40.0, .friction = 5.0}, .lag_kept = 0.95, .direct = 0.08};
  VirtualActuator actuator(healthy);
  actuator.Reconfigure(slow);
  double w = 100.0;
  double lag_v = 2.0;
  for (const double v : {2.5, 2.6, 2.4, 2.5}) {
    const double u = actuator.RigInput(v, w, lag_v);
    EXPECT_NEAR(actuator.ControllerInput(u, w, lag_v), v, 1e-9);
    const double next = slow.motor.Next(w, slow.Handed(u, lag_v));
    EXPECT_NEAR(next, healthy.Next(w, v), 1e-9);
    lag_v = slow.LagNext(lag_v, u);
    w = next;
  }
}

/// The largest distance from the reference in the last fifth of a run of PI, actuator and a rig of
/// which the diagnosis is off.
double LateError(const SpeedModel& healthy, const SpeedModel& rig, const SpeedModel& diagnosed) {
  constexpr double kReference = 150.0;
  constexpr int kTicks = 3000;
  SpeedController controller(healthy, kPeriodS, 0.54);
  VirtualActuator actuator(healthy);
  actuator.Reconfigure(LaggedModel{.motor = diagnosed});
  double w = 100.0;
  double late = 0.0;
  for (int k = 0; k < kTicks; ++k) {
    const double v = controller.Step(kReference, w);
    const double wanted = actuator.RigInput(v, w, 0.0);
    const double given = std::clamp(wanted, 0.0, 10.0);
    if (given != wanted) controller.Applied(actuator.ControllerInput(given, w, 0.0));
    w = std::max(0.0, rig.Next(w, given));
    if (k > kTicks * 4 / 5) late = std::max(late, std::abs(kReference - w));
  }
  return late;
}

TEST(VirtualActuator, IsStableThoughTheDiagnosisIsOffByTwoFifths) {
  const SpeedModel healthy{.kept = 0.57, .gain = 48.0, .friction = 12.0};
  Random random(17);
  int reachable = 0;
  for (int i = 0; i < 1000; ++i) {
    const double slower = std::exp(random.Uniform(-1.5, 2.5));
    const SpeedModel rig{.kept = std::pow(healthy.kept, 1.0 / slower),
                         .gain = healthy.gain * std::exp(random.Uniform(-1.2, 0.7)),
                         .friction = healthy.friction * std::exp(random.Uniform(-1.0, 1.0))};
    if (rig.Settled(10.0) < 160.0) continue;
    ++reachable;
    const auto off = [&] { return random.Uniform(0.6, 1.4); };
    const SpeedModel diagnosed{.kept = std::pow(rig.kept, 1.0 / off()),
                               .gain = rig.gain * off(),
                               .friction = rig.friction * off()};
    EXPECT_LT(LateError(healthy, rig, diagnosed), 1.0)
        << "gain " << rig.gain << " as " << diagnosed.gain << ", kept " << rig.kept << " as "
        << diagnosed.kept;
  }
  EXPECT_GT(reachable, 700);
}

TEST(CompensationCheck, RefutesAWrongDiagnosisAndKeepsARightOne) {
  const SpeedModel healthy{.kept = 0.87, .gain = 100.0, .friction = 20.0};
  const SpeedModel faulty{.kept = 0.91, .gain = 70.0, .friction = 25.0};
  const SpeedModel wrong{.kept = 0.87, .gain = 170.0, .friction = 20.0};
  constexpr double kNoise = 0.5;
  const auto pushes_until = [&](const SpeedModel& rig, const SpeedModel& believed) {
    Random random(3);
    double w = 150.0;
    CompensationCheck check({healthy, 0.0}, {believed, 0.0}, w, 2.5, kNoise);
    for (int k = 0; k < 10'000; ++k) {
      const double u = (k / 200) % 2 == 0 ? 2.5 : 2.7;
      w = rig.Next(w, u);
      const double reading = k % 7 == 0 ? std::nan("") : w + kNoise * random.Normal();
      if (check.Push(reading, u)) return k;
    }
    return -1;
  };
  EXPECT_EQ(pushes_until(faulty, faulty), -1);
  EXPECT_GE(pushes_until(healthy, faulty), 0) << "the part is whole again";
  EXPECT_LT(pushes_until(healthy, faulty), 20);
  EXPECT_GE(pushes_until(faulty, wrong), 0);
  EXPECT_LT(pushes_until(faulty, wrong), 20);
}

/// Whoever sends orders over a bus may send anything that Validate takes.
TEST(TolerantDrive, StaysInsideTheEnvelopeWhateverItIsTold) {
  BenchLimits limits = hardware::LoadBench("paper").value()->limits;
  limits.slew_v_per_s = 40.0;  // less than its range in a period
  Random random(23);
  const auto any = [&] { return std::pow(10.0, random.Uniform(-300.0, 300.0)); };
  const auto model = [&] {
    return DriveModel{
        .speed = {.kept = random.Uniform(0.0, 1.0) > 0.5 ? 1.0 - 1e-16 : random.Uniform(0.0, 1.0),
                  .gain = any(),
                  .friction = random.Uniform(-1.0, 1.0) * any()},
        .gain = any(),
        .resistance_ohm = any(),
        .ke_v_per_rad_s = any(),
        .input_max_v = any(),
        .sustained_rad_s = any(),
        .motor_kept = random.Uniform(0.0, 1.0),
        .lag_kept = random.Uniform(0.0, 1.0),
        .direct = random.Uniform(0.0, 1.0)};
  };
  int taken = 0;
  for (int i = 0; i < 2000; ++i) {
    ControlOrder order{.healthy = model(), .noise_rad_s = any(), .delta_s = any()};
    order.alarmed = random.Uniform(0.0, 1.0) > 0.5;
    order.believed = BelievedFault{{}, any(), model()};
    if (!Validate(order).ok()) continue;
    ++taken;
    TolerantDrive drive(limits, order, kPeriodS, {}, 2.5);
    double before_v = 2.5;
    for (int k = 0; k < 20; ++k) {
      if (k == 10) drive.Heard(order);
      const double reading = k % 5 == 0 ? std::nan("") : random.Uniform(-1.0, 1.0) * any();
      const double input_v = drive.Tick(150.0, reading);
      ASSERT_GE(input_v, limits.uc_v_min) << i;
      ASSERT_LE(input_v, limits.uc_v_max) << i;
      ASSERT_LE(std::abs(input_v - before_v), limits.slew_v_per_s * kPeriodS * (1.0 + 1e-9)) << i;
      before_v = input_v;
    }
  }
  EXPECT_GT(taken, 1000);
}

TEST(TolerantDrive, NeverAsksForMoreThanThePeakCurrent) {
  BenchLimits limits = hardware::LoadBench("paper").value()->limits;
  limits.current_peak_a = 1.0;
  const DriveModel rig{.speed = {.kept = 0.6, .gain = 60.0, .friction = 5.0},
                       .gain = 2.0,
                       .resistance_ohm = 3.0,
                       .ke_v_per_rad_s = 0.03,
                       .input_max_v = 5.0,
                       .sustained_rad_s = 250.0,
                       .motor_kept = 0.6};
  TolerantDrive drive(limits, {.healthy = rig}, kPeriodS, {}, 0.0);
  double w = 0.0;
  for (int k = 0; k < 200; ++k) {
    const double input_v = drive.Tick(k < 100 ? 200.0 : 10.0, w);
    const double current_a = (rig.gain * input_v - rig.ke_v_per_rad_s * w) / rig.resistance_ohm;
    ASSERT_LE(std::abs(current_a), limits.current_peak_a) << k;
    w = rig.speed.Next(w, input_v);
  }
}

/// Also when the trial alone would not refute it: what it has read since was of another value.
TEST(TolerantDrive, DoesNotBelieveARefutedDiagnosisAgain) {
  const BenchLimits limits = hardware::LoadBench("paper").value()->limits;
  const DriveModel rig{.speed = {.kept = 0.6, .gain = 60.0, .friction = 5.0},
                       .input_max_v = 5.0,
                       .sustained_rad_s = 250.0,
                       .motor_kept = 0.6};
  ControlOrder order{.healthy = rig, .noise_rad_s = 0.3};
  TolerantDrive drive(limits, order, kPeriodS, {}, 2.0);
  double w = rig.speed.Settled(2.0);
  const auto play = [&](int ticks) {
    for (int k = 0; k < ticks; ++k) w = rig.speed.Next(w, drive.Tick(w < 120.0 ? 140.0 : 100.0, w));
  };
  DriveModel weaker = rig;
  weaker.speed.gain = 30.0;
  order.believed = BelievedFault{{}, 56.0, weaker};
  drive.Heard(order);
  EXPECT_TRUE(drive.compensates());
  play(100);
  EXPECT_FALSE(drive.compensates());
  EXPECT_TRUE(drive.gave_up());
  order.believed->value = 58.0;  // about the same, without an alarm to try it on
  drive.Heard(order);
  EXPECT_FALSE(drive.compensates());
  order.believed->value = 90.0;
  drive.Heard(order);
  EXPECT_TRUE(drive.compensates()) << "another one";
}

TEST(SpeedController, IsStableAtAPeriodInWhichThePlantSettles) {
  for (const double kept : {1e-6, 0.004, 0.1, 0.5, 0.9}) {
    const SpeedModel plant{.kept = kept, .gain = 60.0, .friction = 5.0};
    SpeedController controller(plant, 0.1, 0.54);
    double w = 100.0;
    double reading = w;  // of the period before: it is read right after the edge
    for (int k = 0; k < 400; ++k) {
      const double v = controller.Step(150.0, reading);
      reading = w;
      w = plant.Next(w, v);
    }
    EXPECT_NEAR(w, 150.0, 0.1) << kept;
  }
}

TEST(SpeedController, DoesNotWindUpWhileTheDriveIsAtItsEnd) {
  const SpeedModel plant{.kept = 0.6, .gain = 60.0, .friction = 0.0};
  SpeedController controller(plant, kPeriodS, 0.27);
  double w = 0.0;
  const auto run = [&](double reference, int ticks) {
    for (int k = 0; k < ticks; ++k) {
      const double v = controller.Step(reference, w);
      const double given = std::clamp(v, 0.0, 5.0);
      if (given != v) controller.Applied(given);
      w = plant.Next(w, given);
    }
  };
  run(400.0, 500);  // 300 is all that it can
  EXPECT_NEAR(w, 300.0, 1e-6);
  run(150.0, 40);
  EXPECT_NEAR(w, 150.0, 2.0) << "it turns back at once";
}

}  // namespace
}  // namespace faultlab::core

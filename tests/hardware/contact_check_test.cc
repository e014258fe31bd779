// Contacts, not only ports: each relay position is recognised by what it does to um and ia.
#include "hardware/contact_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "core/plant/simulate_record.h"
#include "hardware/bench/benches.h"
#include "hardware/bench/shipped_benches.h"
#include "tests/hardware/test_bench.h"

namespace faultlab::hardware {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kPaperDeltaS = 9.5e-3;
const double kDriveV = ContactDrive(paper::Bench());

std::uint32_t Bit(int line) {
  return 1u << line;
}

/// The relay that is on line `from` hears line `to`, and the other way round.
auto Exchanged(int one, int other) {
  return [=](std::uint32_t levels) {
    const bool first = (levels & Bit(one)) != 0;
    const bool second = (levels & Bit(other)) != 0;
    std::uint32_t out = levels & ~(Bit(one) | Bit(other));
    if (first) out |= Bit(other);
    if (second) out |= Bit(one);
    return out;
  };
}

ContactReport ReportOf(TestBench& bench) {
  const core::Result<ContactReport> report = CheckContacts(*bench.rig, Epoch{1});
  EXPECT_TRUE(report.ok()) << (report.ok() ? "" : report.error().message);
  EXPECT_TRUE(bench.journal.drive_v == 0.0);
  return report.ok() ? report.value() : ContactReport{};
}

ContactFinding Of(const ContactReport& report, core::Component component, double value) {
  for (const ContactFinding& finding : report.positions) {
    if (finding.component == component && finding.value == value) return finding;
  }
  ADD_FAILURE() << core::Name(component) << " " << value << " is not in the report";
  return {};
}

TEST(Contacts, OfAHealthyBenchAreAllRecognised) {
  TestBench bench;
  const ContactReport report = ReportOf(bench);
  EXPECT_TRUE(report.ok);
  EXPECT_THAT(report.nominal, IsEmpty());
  ASSERT_EQ(report.positions.size(), 12u);
  for (const ContactFinding& finding : report.positions) {
    EXPECT_EQ(finding.contact, Contact::kRecognised)
        << core::Name(finding.component) << " = " << finding.value << ": um "
        << finding.um_expected_v << " seen " << finding.um_seen_v;
    EXPECT_NEAR(finding.um_seen_v, finding.um_expected_v, 0.05 + 0.05 * finding.um_expected_v);
  }
}

TEST(Contacts, AreRecognisedWithinTheCloserLimitsOfARig) {
  TestBenchOptions options;
  options.limits.uc_v_max = 2.5;
  TestBench bench(options);
  EXPECT_TRUE(ReportOf(bench).ok);
}

TEST(Contacts, ADriveBelowZeroIsUsedWhereTheExcitationIs) {
  core::Bench bench = paper::Bench();
  auto& prbs = std::get<core::PrbsSpec>(bench.excitation);
  prbs.low_v = -2.0;
  prbs.high_v = 0.0;
  EXPECT_DOUBLE_EQ(ContactDrive(bench), -2.0);
}

TEST(Contacts, ExchangedWiresAreNamed) {
  TestBench bench;
  bench.journal.wires = Exchanged(0, 1);  // R1: 100 ohm and 56 ohm
  const ContactReport report = ReportOf(bench);
  EXPECT_FALSE(report.ok);
  const ContactFinding finding = Of(report, paper::kR1, 56.0);
  EXPECT_EQ(finding.contact, Contact::kWrong);
  EXPECT_THAT(finding.text, HasSubstr("looks like 100 ohm of Do0"));
  EXPECT_EQ(Of(report, paper::kR1, 10.0).contact, Contact::kRecognised);
  EXPECT_EQ(Of(report, paper::kR9, 33e3).contact, Contact::kRecognised);
}

TEST(Contacts, AWireOnTheWrongBoardIsFound) {
  TestBench bench;
  bench.journal.wires = Exchanged(16, 18);  // R1 = 10 ohm and R9 = 33 kohm
  const ContactReport report = ReportOf(bench);
  EXPECT_EQ(Of(report, paper::kR1, 10.0).contact, Contact::kWrong);
  EXPECT_EQ(Of(report, paper::kR9, 33e3).contact, Contact::kWrong);
}

TEST(Contacts, ANominalPartOnAnotherLineIsFound) {
  TestBench bench;
  bench.journal.wires = Exchanged(19, 18);  // R9: 10 kohm and 33 kohm
  const ContactReport report = ReportOf(bench);
  EXPECT_FALSE(report.ok);
  EXPECT_THAT(report.nominal, HasSubstr("with all positions nominal um is"));
}

TEST(Contacts, ABoardWithoutSupplySwitchesNothing) {
  TestBench bench;
  const std::uint32_t r12 = Bit(6) | Bit(7) | Bit(22) | Bit(23);
  bench.journal.wires = [=](std::uint32_t levels) { return (levels | r12) & ~Bit(6); };
  const ContactReport report = ReportOf(bench);
  for (const double value : {5.6e3, 3.3e3, 2e3}) {
    const ContactFinding finding = Of(report, paper::kR12, value);
    EXPECT_EQ(finding.contact, Contact::kWrong) << value;
    EXPECT_THAT(finding.text, HasSubstr("nothing changes"));
  }
  EXPECT_EQ(Of(report, paper::kC8, 10e-6).contact, Contact::kRecognised);
}

TEST(Contacts, AContactThatDoesNotCloseIsFound) {
  TestBench bench;
  bench.journal.wires = [](std::uint32_t levels) { return levels | Bit(1); };  // R1 = 56 ohm open
  const ContactReport report = ReportOf(bench);
  EXPECT_EQ(Of(report, paper::kR1, 56.0).contact, Contact::kWrong);
  EXPECT_THAT(Of(report, paper::kR1, 56.0).text, HasSubstr("an open contact"));
  EXPECT_EQ(Of(report, paper::kR1, 100.0).contact, Contact::kRecognised);
}

/// A run of the plan on a rig that is not its data sheet.
std::vector<core::Sample> RunOn(const core::PlantParameters& rig, double mc_nm) {
  const RunPlan plan = ContactPlan(paper::Bench(), kDriveV);
  core::BenchProfile profile = paper::Hardware();
  profile.friction.mc_nm = mc_nm;
  profile.friction.ms_nm = 1.5 * mc_nm;
  return core::SimulateRecord(profile, rig, plan.uc_v, plan.faults, 7, plan.period_s);
}

TEST(Contacts, ToleranceOfPartsAndFrictionAreNoWrongWires) {
  for (const double share : {0.95, 1.05}) {
    for (const double mc_nm : {0.15e-3, 0.6e-3}) {
      core::PlantParameters rig = paper::Bench().nominal;
      rig.ra_ohm *= share;
      rig.ke_v_per_rad_s *= 2.0 - share;
      rig.kt_nm_per_a *= 2.0 - share;
      const ContactReport report =
          JudgeContacts(RunOn(rig, mc_nm), paper::Bench(), kDriveV, kPaperDeltaS);
      EXPECT_TRUE(report.ok) << share << " " << mc_nm << " " << report.nominal;
      for (const ContactFinding& finding : report.positions) {
        EXPECT_NE(finding.contact, Contact::kWrong)
            << core::Name(finding.component) << " = " << finding.value << ": " << finding.text;
      }
    }
  }
}

TEST(Contacts, APartOfAnotherSizeIsToBeMeasured) {
  RunPlan plan = ContactPlan(paper::Bench(), kDriveV);
  for (core::Fault& fault : plan.faults) {
    if (fault.component == paper::kR1 && fault.value == 100.0) fault.value = 1000.0;
  }
  const ContactReport report = JudgeContacts(
      core::SimulateRecord(
          paper::Hardware(), paper::Bench().nominal, plan.uc_v, plan.faults, 7, plan.period_s),
      paper::Bench(),
      kDriveV,
      kPaperDeltaS);
  const ContactFinding finding = Of(report, paper::kR1, 100.0);
  EXPECT_EQ(finding.contact, Contact::kWrong);
  EXPECT_THAT(finding.text, HasSubstr("of another size"));
}

TEST(Contacts, APartWithoutEffectIsReadBackOnly) {
  core::Bench bench = paper::Bench();
  std::vector<core::Component> parts;
  for (core::ComponentInfo& part : bench.parts) {
    if (part.symbol == "C8") part.positions[1].value = 48e-12;
  }
  const RunPlan plan = ContactPlan(bench, kDriveV);
  const std::vector<core::Sample> record = core::SimulateRecord(
      paper::Hardware(), bench.nominal, plan.uc_v, plan.faults, 7, plan.period_s);
  const ContactReport report = JudgeContacts(record, bench, kDriveV, kPaperDeltaS);
  EXPECT_TRUE(report.ok);
  for (const ContactFinding& finding : report.positions) {
    EXPECT_EQ(finding.contact,
              finding.value == 48e-12 ? Contact::kReadBackOnly : Contact::kRecognised)
        << core::Name(finding.component) << " " << finding.value;
  }
}

TEST(Contacts, LostSamplesAndNoSamplesAreNoRecognition) {
  const RunPlan plan = ContactPlan(paper::Bench(), kDriveV);
  EXPECT_FALSE(JudgeContacts({}, paper::Bench(), kDriveV, kPaperDeltaS).ok);
  std::vector<core::Sample> record = RunOn(paper::Bench().nominal, 0.33e-3);
  std::erase_if(record, [](const core::Sample& sample) { return sample.index % 7 == 3; });
  EXPECT_TRUE(JudgeContacts(record, paper::Bench(), kDriveV, kPaperDeltaS).ok);
}

TEST(Contacts, TheRunStaysInsideEveryShippedBench) {
  for (const ShippedBench& shipped : ShippedBenches()) {
    const core::Bench* bench = LoadBench(std::string(shipped.name)).value();
    SimulatedRigOptions options;
    options.bench = bench;
    options.speed = 0.0;
    const std::unique_ptr<Rig> rig = MakeSimulatedRig(options);
    const core::Result<ContactReport> report = CheckContacts(*rig, Epoch{1});
    ASSERT_TRUE(report.ok()) << bench->name << ": " << report.error().message;
    EXPECT_TRUE(report.value().ok) << bench->name << ": " << report.value().nominal;
  }
}

}  // namespace
}  // namespace faultlab::hardware

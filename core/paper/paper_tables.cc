#include "core/paper/paper_tables.h"

#include "core/types/check.h"

namespace faultlab::core {
namespace {

// clang-format off
// component, value, table, fits
constexpr std::array<PaperFault, kPaperFaultCount> kFaults = {{
    {"R1", 10.0, 14, {95.71, 96.42, 70.78, 69.0, 72.11}},
    {"R1", 56.0, 14, {81.65, 86.5, -30.61, 35.13, 76.74}},
    {"R1", 100.0, 14, {74.44, 76.75, -150.2, -17.67, 79.0}},
    {"R9", 33e3, 15, {97.7, 97.14, 90.54, 89.01, 89.52}},
    {"R9", 56e3, 15, {97.28, 96.72, 91.07, 89.26, 89.87}},
    {"R9", 100e3, 15, {93.09, 97.57, 90.25, 88.27, 88.93}},
    {"R12", 2000.0, 16, {98.32, 98.57, 92.14, 90.0, 90.89}},
    {"R12", 3300.0, 16, {95.89, 98.59, 92.0, 91.4, 91.6}},
    {"R12", 5600.0, 16, {98.77, 97.96, 92.48, 91.52, 91.89}},
    {"C8", 1e-6, 17, {97.85, 90.6, 75.41, 75.4, 75.43}},
    {"C8", 1e-5, 17, {95.07, 97.57, 88.53, 89.04, 88.98}},
    {"C8", 4.7e-5, 17, {87.96, 96.72, 96.3, 96.69, 96.7}},
    {"Ra", 0.741, 18, {99.68, 89.53, 95.43, 95.01, 95.25}},
    {"Ra", 74.1, 18, {95.84, 99.31, 99.75, 98.53, 98.93}},
    {"J", 0.000143, 19, {85.84, 96.63, 99.59, 98.72, 99.12}},
    {"J", 1.43e-8, 19, {82.76, 82.69, 75.73, 75.71, 75.73}},
    {"B", 0.00018, 20, {99.54, 99.21, 96.88, 96.84, 96.86}},
    {"B", 1.8e-5, 20, {99.45, 99.1, 96.5, 96.2, 96.35}},
}};
// clang-format on

constexpr PaperFits kNominalFits = {98.6, 98.59, 92.27, 91.92, 92.0};

constexpr std::array<const char*, kPaperTableLast - kPaperTableFirst + 1> kTitles = {
    "Amplifier parameters by SWA, faults in R1 and R9",
    "Amplifier parameters by SWA, faults in R12 and C8",
    "Motor parameters by SWA, faults in Ra and J",
    "Motor parameters by SWA, faults in B",
    "Amplifier parameters by SIA, faults in R1 and R9",
    "Amplifier parameters by SIA, faults in R12 and C8",
    "Motor parameters by SIA, faults in Ra and J",
    "Motor parameters by SIA, faults in B",
    "Identified amplifier components",
    "Identified motor components",
    "Fit before any fault",
    "Fit under faults in R1",
    "Fit under faults in R9",
    "Fit under faults in R12",
    "Fit under faults in C8",
    "Fit under faults in Ra",
    "Fit under faults in J",
    "Fit under faults in B"};

}  // namespace

const std::array<PaperFault, kPaperFaultCount>& PrintedFaults() {
  return kFaults;
}

const PaperFits& PaperNominalFits() {
  return kNominalFits;
}

const char* PaperTableTitle(int table) {
  LAB_CHECK(table >= kPaperTableFirst && table <= kPaperTableLast, table);
  return kTitles[static_cast<std::size_t>(table - kPaperTableFirst)];
}

}  // namespace faultlab::core

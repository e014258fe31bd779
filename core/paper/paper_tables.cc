#include "core/paper/paper_tables.h"

#include "core/types/check.h"

namespace faultlab::core {
namespace {

// clang-format off
// component, value, SWA table {b0d, b1d, a1d}, SIA table {b0, b1, a1}, identified, fits
constexpr std::array<PaperFault, kPaperFaultCount> kFaults = {{
    {Component::kR1, 10.0, 3, {1.421, -0.82, -0.738}, 7, {2.306, 0.0546, 0.038}, 11, 9.8, 14, {95.71, 96.42, 70.78, 69.0, 72.11}},
    {Component::kR1, 56.0, 3, {0.472, -0.279, -0.896}, 7, {1.85, 0.047, 0.15}, 11, 49.0, 14, {81.65, 86.5, -30.61, 35.13, 76.74}},
    {Component::kR1, 100.0, 3, {0.29, -0.18, -0.925}, 7, {1.495, 0.0352, 0.126}, 11, 79.0, 14, {74.44, 76.75, -150.2, -17.67, 79.0}},
    {Component::kR9, 33e3, 3, {1.488, -0.5, -0.373}, 7, {1.331, 0.0245, 0.0199}, 11, 17e3, 15, {97.7, 97.14, 90.54, 89.01, 89.52}},
    {Component::kR9, 56e3, 3, {1.337, -0.412, -0.35}, 7, {1.425, 0.03, 0.0221}, 11, 18.2e3, 15, {97.28, 96.72, 91.07, 89.26, 89.87}},
    {Component::kR9, 100e3, 3, {1.258, -0.359, -0.316}, 7, {1.575, 0.032, 0.022}, 11, 19e3, 15, {93.09, 97.57, 90.25, 88.27, 88.93}},
    {Component::kR12, 2000.0, 4, {0.757, -0.368, -0.514}, 8, {0.8, 0.0175, 0.023}, 11, 2000.0, 16, {98.32, 98.57, 92.14, 90.0, 90.89}},
    {Component::kR12, 3300.0, 4, {1.0, -0.458, -0.492}, 8, {1.059, 0.0228, 0.0228}, 11, 3300.0, 16, {95.89, 98.59, 92.0, 91.4, 91.6}},
    {Component::kR12, 5600.0, 4, {1.434, -0.784, -0.572}, 8, {1.521, 0.0325, 0.022}, 11, 5600.0, 16, {98.77, 97.96, 92.48, 91.52, 91.89}},
    {Component::kC8, 1e-6, 4, {1.148, -0.013, -0.526}, 8, {2.39, 0.024, 0.0209}, 11, 9.7e-7, 17, {97.85, 90.6, 75.41, 75.4, 75.43}},
    {Component::kC8, 1e-5, 4, {0.312, -0.142, -0.929}, 8, {2.387, 0.044, 0.141}, 11, 9.7e-6, 17, {95.07, 97.57, 88.53, 89.04, 88.98}},
    {Component::kC8, 4.7e-5, 4, {0.21, -0.168, -0.982}, 8, {2.386, 0.1142, 0.56}, 11, 4.6e-5, 17, {87.96, 96.72, 96.3, 96.69, 96.7}},
    {Component::kRa, 0.741, 5, {1.9, 0.356, -0.06}, 9, {2.393, 0.02, 0.011}, 12, 0.62, 18, {99.68, 89.53, 95.43, 95.01, 95.25}},
    {Component::kRa, 74.1, 5, {2.369, -2.227, -0.94}, 9, {2.395, 0.143, 0.06}, 12, 64.4, 18, {95.84, 99.31, 99.75, 98.53, 98.93}},
    {Component::kJ, 0.000143, 5, {2.12, -2.13, -1.0}, 9, {2.392, 3.794, 1.824}, 12, 0.000143, 19, {85.84, 96.63, 99.59, 98.72, 99.12}},
    {Component::kJ, 1.43e-8, 5, {2.34, -0.192, -0.083}, 9, {2.394, 0.018, 0.008}, 12, 1.45e-8, 19, {82.76, 82.69, 75.73, 75.71, 75.73}},
    {Component::kB, 0.00018, 6, {2.162, -0.34, -0.172}, 10, {2.2, 0.026, 0.012}, 12, 5.7e-5, 20, {99.54, 99.21, 96.88, 96.84, 96.86}},
    {Component::kB, 1.8e-5, 6, {2.177, -1.062, -0.524}, 10, {2.346, 0.0462, 0.0213}, 12, 1.53e-5, 20, {99.45, 99.1, 96.5, 96.2, 96.35}},
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

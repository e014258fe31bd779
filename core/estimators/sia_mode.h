#pragma once

namespace faultlab::core {

/// How SIA interprets its least-squares solution theta' = {b0', b1', a1'}.
///   kPaper: as printed, theta = theta'. The rectangular rule makes a1' = T / (1 - exp(-T/a1)) and
///           b1' = a1' b0d, 30 % above a1 and b1 at nominal: reproduces the paper's Tables 7-10.
///   kExact: rule inverted, a1 = -T / ln(1 - T/a1'),  b1 = a1 (b0 - (b0 - b1'/a1') exp(delta/a1)),
///           where delta is the time from the DAC edge to the ADC sample. First order only.
enum class SiaMode { kPaper, kExact };

}  // namespace faultlab::core

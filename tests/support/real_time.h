#pragma once

#include <functional>

namespace faultlab::tests {

/// Runs the tests of a program whose processes must keep up with real time. On a busy host, which
/// takes cores away, they fail although the product is right. Therefore a failure counts only if no
/// core was away for more than 20 ms during the tests. Otherwise the program is started again with
/// the failed tests, five times at most, and prints this.
/// @param at_end  called each time after the tests have run
/// @returns what main returns; does not return if the program is started again
int RunInRealTime(int argc, char** argv, const std::function<void()>& at_end = {});

}  // namespace faultlab::tests

#pragma once

#include <functional>

namespace faultlab::tests {

/// Runs the tests of a program whose processes must keep up with real time. On a machine that
/// takes its cores away (a busy host) they fail for no fault of the product: a failure counts when
/// no core was away for more than 20 ms meanwhile. Otherwise the program begins anew with the
/// tests that failed, five times at most, and says so.
/// @param at_end  called when the tests have run, each time
/// @returns what main returns; does not return where the program begins anew
int RunInRealTime(int argc, char** argv, const std::function<void()>& at_end = {});

}  // namespace faultlab::tests

#pragma once

namespace faultlab::server {

/// The program `faultlab`: parses its words and calls one function.
/// @returns its exit status
int RunCommandLine(int argc, char** argv);

}  // namespace faultlab::server

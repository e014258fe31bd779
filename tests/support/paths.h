#pragma once

#include <string>

/// Where the sources and the built files of this checkout are. Here only, so that no other object
/// file of the tests holds an absolute path and the compiler cache serves every checkout.
namespace faultlab::tests {

std::string InSource(
    const std::string& path);  ///< a file of the checkout: "tests/data/nofault.csv.gz"
std::string InBuild(const std::string& path);  ///< a built file: "tests/hardware/libstand_in.so"
std::string Program();  ///< the program faultlab that was built with the tests

}  // namespace faultlab::tests

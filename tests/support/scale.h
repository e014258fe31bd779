#pragma once

#include <algorithm>
#include <cstdlib>
#include <string_view>
#include <vector>

namespace faultlab::tests {

/// True in `deploy/prove`, which has hours; the check takes a sample of the same.
inline bool Proving() {
  const char* const text = std::getenv("FAULTLAB_PROVE");
  return text != nullptr && std::string_view(text) == "1";
}

/// The seeds of a study, `first` to `end` - 1: all of them in `deploy/prove`, which computes
/// without sanitizers. The check takes the first quarter, at least two.
inline std::vector<unsigned> Seeds(unsigned first, unsigned end) {
  std::vector<unsigned> seeds;
  for (unsigned seed = first; seed < end; ++seed) seeds.push_back(seed);
  if (!Proving())
    seeds.resize(std::min<std::size_t>(seeds.size(), std::max<std::size_t>(2, seeds.size() / 4)));
  return seeds;
}

}  // namespace faultlab::tests

#include "core/paper/reproduction/errata.h"

#include <array>
#include <string_view>

namespace faultlab::core {
namespace {

struct Erratum {
  int table;
  std::string_view component;  ///< its symbol
  double value;                ///< 0: every value
  const char* name;            ///< "": every name; otherwise the name of the row or its beginning
  const char* text;
};

constexpr std::array kErrata = {
    Erratum{3, "R9", 0.0, "a1d", "carries the noise bias of the paper's own record"},
    Erratum{5, "J", 1.43e-4, "a1d", "-1 is rounding: the exact value is -0.9945"},
    Erratum{5, "J", 1.43e-8, "b1d", "0.2 ms is invisible at T = 10 ms: b1d, a1d near 0"},
    Erratum{5, "J", 1.43e-8, "a1d", "0.2 ms is invisible at T = 10 ms: b1d, a1d near 0"},
    Erratum{7, "R9", 33e3, "", "row exchanged in print with 100 kohm; compared with it"},
    Erratum{7, "R9", 100e3, "", "row exchanged in print with 33 kohm; compared with it"},
    Erratum{9, "Ra", 74.1, "b1", "pole and zero nearly cancel: b1 and a1 are not defined"},
    Erratum{9, "Ra", 74.1, "a1", "pole and zero nearly cancel: b1 and a1 are not defined"},
    Erratum{9, "J", 1.43e-8, "b1", "0.2 ms is invisible at T = 10 ms: b1, a1 are bounds"},
    Erratum{9, "J", 1.43e-8, "a1", "0.2 ms is invisible at T = 10 ms: b1, a1 are bounds"},
    Erratum{11, "C8", 0.0, "Eq. 42", "Eq. 41 prints dC8 in the b0 row: factor 0.967"},
    Erratum{18, "Ra", 0.741, "mc_", "not reproducible with the paper's delta = 0"},
    Erratum{19, "J", 1.43e-8, "", "not reproducible by any setting: 99.8 % is right"}};

}  // namespace

std::string ErratumOf(int table, const std::optional<TableFault>& fault, const std::string& name) {
  for (const Erratum& erratum : kErrata) {
    if (fault && erratum.table == table && erratum.component == Name(fault->component) &&
        (erratum.value == 0.0 || erratum.value == fault->value) &&
        name.compare(0, std::string(erratum.name).size(), erratum.name) == 0) {
      return erratum.text;
    }
  }
  return {};
}

}  // namespace faultlab::core

#include "hardware/self_test.h"

#include <string>
#include <utility>

#include "hardware/io_error.h"

namespace faultlab::hardware {

SelfTestReport WalkPositions(
    const RelayWiring& wiring,
    const RelayBoard& relays,
    const std::function<void(core::Component component, int position)>& connect) {
  SelfTestReport report{.positions = {}, .ok = true};
  for (const core::Component component : wiring.boards) {
    const auto& positions = component.info().positions;
    for (int position = 0; position < static_cast<int>(positions.size()); ++position) {
      SelfTestPosition result{.component = component,
                              .value = positions[static_cast<std::size_t>(position)].value,
                              .line = "Do" + std::to_string(relays.line(component, position)),
                              .ok = true,
                              .text = {}};
      try {
        connect(component, position);
      } catch (const IoError& error) {
        result.ok = false;
        result.text = error.what();
      }
      report.ok = report.ok && result.ok;
      report.positions.push_back(std::move(result));
    }
  }
  return report;
}

}  // namespace faultlab::hardware

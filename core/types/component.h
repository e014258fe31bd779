#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "core/types/structure.h"

namespace faultlab::core {

/// A value that the bench's relays can connect, and the line that connects it.
struct SwitchPosition {
  double value = 0.0;  ///< SI
  int line = 0;        ///< Do<line>
};

enum class SwitchOrder {
  kBreakBeforeMake,  ///< two parts are never connected at once
  kMakeBeforeBreak,  ///< the circuit is never open
};

/// One part of a bench whose faults are known to the laboratory.
struct ComponentInfo {
  std::string symbol;  ///< "R1", unique in its bench
  std::string unit;    ///< SI, of every value
  int index = 0;       ///< in the bench's list
  int parameter = 0;   ///< of the structure: what it changes
  int coupled = -1;    ///< a parameter that changes in the same proportion (KT with Ke), or -1
  double coupled_ratio = 0.0;  ///< its nominal value over `nominal`
  PartKind kind = PartKind::kOther;
  double nominal = 0.0;
  std::vector<SwitchPosition> positions;  ///< nominal first; empty: only a simulator changes it
  SwitchOrder order = SwitchOrder::kBreakBeforeMake;
  std::vector<double> offered;    ///< simulators' values besides `positions` and nominal
  std::vector<double> published;  ///< values for which a publication prints numbers
  double value_min = 0.0;         ///< range in which a diagnosis searches the value
  double value_max = 0.0;
  int scan_points = 24;        ///< of the first scan of that range
  double least_visible = 0.0;  ///< smaller values have the same effect; 0: no such limit
};

inline constexpr int kComponentsMax = 16;
inline constexpr std::size_t kSymbolBytesMax = 16;

/// A component of a bench, as cheap to copy as a number. Benches exist until the process ends
/// (hardware/bench/benches.h), so the reference stays valid. Two components are equal when they
/// have the same place in the same bench. Contract of every use but ==: not default-constructed.
class Component {
 public:
  Component() = default;
  explicit Component(const ComponentInfo& info) : info_(&info) {}

  bool exists() const { return info_ != nullptr; }
  const ComponentInfo& info() const;
  friend bool operator==(Component, Component) = default;

 private:
  const ComponentInfo* info_ = nullptr;
};

/// Orders the components of one bench as in its list.
struct ByIndex {
  bool operator()(Component a, Component b) const { return a.info().index < b.info().index; }
};

inline std::string_view Name(Component component) {
  return component.info().symbol;
}
/// The SI unit in which every value is given.
inline std::string_view Unit(Component component) {
  return component.info().unit;
}
inline int Index(Component component) {
  return component.info().index;
}
/// True when relays of the bench change it; others need a simulator.
inline bool IsSwitched(Component component) {
  return !component.info().positions.empty();
}

}  // namespace faultlab::core

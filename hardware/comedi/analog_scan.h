#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "hardware/comedi/comedi_board.h"

namespace faultlab::hardware {

/// Conversions that the board's own timer starts: one scan of the inputs, its middle a fixed time
/// after the drive's edge, whenever the program comes to fetch it.
///
///   drive edge, Start |---- scan_begin ----| um | ua | ia |   Collect
///                     |------- middle_after -----^
///
/// Boards differ in their first scan. Some begin it with the command: the scan wanted is then the
/// second, and the first is thrown away. Some begin it a period later. A trial at the beginning
/// tells which.
class AnalogScan {
 public:
  struct Inputs {
    unsigned subdevice = 0;
    std::vector<unsigned> channels;  ///< CR_PACK each
  };
  struct Scan {
    std::vector<lsampl_t> codes;  ///< in the order of the inputs
    double middle_after_s = 0.0;  ///< from the return of the drive's write
  };

  /// @param delta_s  wanted from the drive's edge to the middle of the scan
  /// @returns null when the board does not clock such a scan: no commands, no timer for scans and
  ///          conversions, too slow, no data came, or another program has the subdevice
  static std::unique_ptr<AnalogScan> Of(const ComediBoard& board, Inputs inputs, double delta_s);

  ~AnalogScan();
  AnalogScan(const AnalogScan&) = delete;
  AnalogScan& operator=(const AnalogScan&) = delete;

  /// Call at once after the drive's write. Ends a scan that was not collected. Does not throw: a
  /// safe stop writes the drive too. What went wrong is told by Collect.
  void Start() noexcept;
  /// Waits for the scan begun last. Throws IoError when it could not begin, was broken off, or has
  /// not come in kPatience after its time.
  Scan Collect();

  static constexpr std::chrono::milliseconds kPatience{50};

 private:
  using Steady = std::chrono::steady_clock;

  AnalogScan(const ComediBoard& board, Inputs inputs);

  bool Plan(double delta_s);
  bool TellFirstScan();
  comedi_cmd Command(std::chrono::nanoseconds scan_begin, unsigned scans);
  /// @returns true when the board takes the command, its times rounded as the board can
  bool Test(comedi_cmd& command) const;
  void Begin(comedi_cmd& command);
  std::vector<lsampl_t> Fetch(std::size_t values, Steady::time_point deadline);
  void Cancel() noexcept;

  const ComediBoard& board_;
  Inputs inputs_;
  std::size_t value_bytes_ = 2;
  comedi_cmd command_{};
  std::chrono::nanoseconds middle_{0};  ///< of the wanted scan, from the command
  bool pending_ = false;
  Steady::time_point edge_{};
  Steady::time_point began_{};
  std::string failure_;  ///< of Start
};

}  // namespace faultlab::hardware

#include "server/cli/calibration_file.h"

#include "server/csv/file_io.h"
#include "server/diagnosis_json/calibration_json.h"

namespace faultlab::server {

core::Result<core::Calibration> ReadCalibrationFile(const std::string& path) {
  constexpr std::size_t kBytesMax = std::size_t{1} << 20;
  const core::Result<std::string> text = ReadFile(path, kBytesMax);
  if (!text) {
    return text.error();
  }
  return ParseCalibration(text.value(), path);
}

}  // namespace faultlab::server

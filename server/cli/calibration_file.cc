#include "server/cli/calibration_file.h"

#include <boost/json.hpp>

#include "server/csv/file_io.h"
#include "server/diagnosis_json/calibration_json.h"
#include "server/json/kept_json.h"

namespace faultlab::server {

namespace json = boost::json;

core::Result<core::Calibration> ReadCalibrationFile(const std::string& path,
                                                    const core::Bench& bench) {
  constexpr std::size_t kBytesMax = std::size_t{1} << 20;
  TRY(const auto text, ReadFile(path, kBytesMax));
  const json::value value = ParsedOr(text);
  const json::value* of = MemberIn(value, "bench");
  if (of != nullptr && of->is_string() && of->get_string() != bench.name) {
    return core::Error{core::ErrorCode::kInvalid,
                       path + ": of a rig of bench '" + std::string(of->get_string()) +
                           "', not of '" + bench.name + "'; give the file of that bench as --bench",
                       "bench"};
  }
  const json::value* id = MemberIn(value, "bench_id");
  if (id != nullptr && id->is_string() && id->get_string() != bench.id) {
    return core::Error{core::ErrorCode::kInvalid,
                       path + ": the bench '" + bench.name +
                           "' was described otherwise when this was measured (" +
                           std::string(id->get_string()) + ", now " + bench.id +
                           "); calibrate again, or give the file of then as --bench",
                       "bench_id"};
  }
  return ParseCalibration(text, path, bench);
}

core::Status WriteCalibrationFile(const std::string& path,
                                  const core::Calibration& calibration,
                                  const core::Bench& bench) {
  json::object document = ToJson(calibration, bench);
  document["bench"] = bench.name;
  document["bench_id"] = bench.id;
  return WriteFile(path, json::serialize(document) + "\n");
}

}  // namespace faultlab::server

#include "server/experiment/work.h"

#include <boost/json.hpp>
#include <utility>

#include "server/experiment/plan_json.h"
#include "server/json/json_reader.h"

namespace faultlab::server {

core::Result<Work> ParseWork(const boost::json::object& object, std::uint64_t default_seed) {
  if (object.contains("diagnose")) {
    auto request = ParseDiagnosisRequest(object);
    if (!request) return request.error();
    return Work(std::move(request).value());
  }
  auto plan = ParsePlan(object, default_seed);
  if (!plan) return plan.error();
  return Work(std::move(plan).value());
}

core::Result<Work> ParseWork(std::string_view document, std::uint64_t default_seed) {
  const auto object = ParseJsonObject(document);
  if (!object) return object.error();
  return ParseWork(object.value(), default_seed);
}

}  // namespace faultlab::server

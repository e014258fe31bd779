#include "tests/server/api/secret_search.h"

#include <boost/json.hpp>
#include <cstring>
#include <iomanip>
#include <sstream>

namespace faultlab::server {

std::vector<std::string> TracesOf(const std::vector<double>& secrets) {
  std::vector<std::string> traces;
  for (const double value : secrets) {
    traces.push_back(boost::json::serialize(boost::json::value(value)));
    std::ostringstream plain;
    plain << std::setprecision(15) << value;
    traces.push_back(plain.str());
    std::string bytes(sizeof value, '\0');
    std::memcpy(bytes.data(), &value, sizeof value);
    traces.push_back(bytes);
    traces.emplace_back(bytes.rbegin(), bytes.rend());
  }
  return traces;
}

std::string TargetOf(std::string path, const std::string& run) {
  const auto put = [&path](const std::string& what, const std::string& value) {
    const std::size_t at = path.find(what);
    if (at != std::string::npos) path.replace(at, what.size(), value);
  };
  const bool of_run = path.find("/runs/{") != std::string::npos;
  const bool of_rig = path.find("/rigs/{") != std::string::npos;
  put("{id}", of_run ? run : of_rig ? "sim-1" : "1");
  put("{figure}", "signals");
  put("{bench}", "paper");
  put("{class}", "bench");
  put("{index}", "0");
  put("{token}", "1");
  return path.ends_with("/comparison.png") ? path + "?runs=" + run : path;
}

bool IsFile(const std::string& path) {
  return path.substr(path.rfind('/')).find('.') != std::string::npos;
}

}  // namespace faultlab::server

#include "server/cli/figure_file.h"

#include <boost/json/serialize.hpp>

#include "server/csv/file_io.h"
#include "server/plots/figure_json.h"
#include "server/plots/render.h"

namespace faultlab::server {

core::Status WriteFigure(const Figure& figure, const std::string& path, int scale) {
  if (path.ends_with(".json")) {
    return WriteFile(path, boost::json::serialize(ToJson(figure)) + "\n");
  }
  RenderOptions options;
  options.scale = scale;
  const core::Result<std::string> png = RenderPng(figure, options);
  return png ? WriteFile(path, png.value()) : core::Status(png.error());
}

}  // namespace faultlab::server

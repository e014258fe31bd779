#pragma once

#include <span>
#include <string_view>

#include "server/net/router.h"

namespace faultlab::server {

/// One file of the web page, built into the program.
struct EmbeddedFile {
  std::string_view path;  ///< "/assets/index-3f2a.js"
  std::string_view bytes;
  std::string_view gzip;  ///< empty when compression does not make it smaller
  std::string_view etag;  ///< quoted
};

/// The files that the build found in web/dist (deploy/build-web).
std::span<const EmbeddedFile> EmbeddedFiles();
std::string_view EmbeddedOpenApi();

/// Routes "/*" to the files: ETag, gzip when asked for, a year of cache for hashed names. Paths of
/// the page's own router ("/runs/x") get index.html. Never touches the disk.
void AddStaticRoutes(Router& router, std::span<const EmbeddedFile> files);

}  // namespace faultlab::server

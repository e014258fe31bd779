#include "server/app/static_files.h"

#include <algorithm>
#include <array>
#include <utility>

namespace faultlab::server {
namespace {

std::string_view ContentType(std::string_view path) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 13> kTypes = {{
      {".html", "text/html; charset=utf-8"},
      {".js", "text/javascript; charset=utf-8"},
      {".css", "text/css; charset=utf-8"},
      {".py", "text/x-python; charset=utf-8"},
      {".svg", "image/svg+xml"},
      {".json", "application/json"},
      {".png", "image/png"},
      {".ico", "image/x-icon"},
      {".woff2", "font/woff2"},
      {".txt", "text/plain; charset=utf-8"},
      {".webmanifest", "application/manifest+json"},
      {".map", "application/json"},
      {".wasm", "application/wasm"},
  }};
  for (const auto& [ending, type] : kTypes) {
    if (path.ends_with(ending)) return type;
  }
  return "application/octet-stream";
}

const EmbeddedFile* FindFile(std::span<const EmbeddedFile> files, std::string_view path) {
  const auto found = std::ranges::find(files, path, &EmbeddedFile::path);
  return found == files.end() ? nullptr : &*found;
}

bool HasExtension(std::string_view path) {
  return path.substr(path.rfind('/') + 1).find('.') != std::string_view::npos;
}

HttpResponse Answer(const HttpRequest& request, const EmbeddedFile& file) {
  HttpResponse response;
  response.content_type = ContentType(file.path);
  response.headers.emplace_back("ETag", std::string(file.etag));
  const bool hashed = file.path.starts_with("/assets/");
  response.headers.emplace_back("Cache-Control",
                                hashed ? "public, max-age=31536000, immutable" : "no-cache");
  if (!file.gzip.empty()) response.headers.emplace_back("Vary", "Accept-Encoding");
  if (request.Header("If-None-Match").find(file.etag) != std::string_view::npos) {
    response.status = 304;
    return response;
  }
  response.static_body = file.bytes;
  if (!file.gzip.empty() &&
      request.Header("Accept-Encoding").find("gzip") != std::string_view::npos) {
    response.static_body = file.gzip;
    response.headers.emplace_back("Content-Encoding", "gzip");
  }
  return response;
}

HttpResponse ServeStatic(const HttpRequest& request, std::span<const EmbeddedFile> files) {
  const std::string_view path = request.path == "/" ? "/index.html" : request.path;
  if (const EmbeddedFile* file = FindFile(files, path)) return Answer(request, *file);
  const bool page = !HasExtension(path) && !path.starts_with("/api/");
  const EmbeddedFile* index = FindFile(files, "/index.html");
  if (page && index != nullptr) return Answer(request, *index);
  return Problem(404, "not_found", "Not found", "There is nothing at this address.");
}

}  // namespace

void AddStaticRoutes(Router& router, std::span<const EmbeddedFile> files) {
  router.Add({HttpMethod::kGet, "/*", RunsOn::kInline, 0, [files](const HttpRequest& request) {
                return ServeStatic(request, files);
              }});
}

}  // namespace faultlab::server

#include "server/net/http.h"

#include <algorithm>
#include <array>

#include "core/types/check.h"
#include "core/types/utf8.h"

namespace faultlab::server {
namespace {

char Lower(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

int HexDigit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

/// Removes the part before `separator` from the front of `rest` and returns it.
std::string_view TakeUntil(std::string_view& rest, char separator) {
  const std::size_t end = rest.find(separator);
  const std::string_view part = rest.substr(0, end);
  rest = end == std::string_view::npos ? std::string_view() : rest.substr(end + 1);
  return part;
}

/// Without its end, so that members can follow.
HttpResponse OpenProblem(int status,
                         std::string_view type,
                         std::string_view title,
                         std::string_view detail,
                         std::string_view field) {
  HttpResponse response;
  response.status = status;
  response.content_type = "application/problem+json";
  std::string& body = response.body;
  body.append("{\"type\":");
  AppendJsonString(body, "/problems/" + std::string(type));
  body.append(",\"title\":");
  AppendJsonString(body, title);
  body.append(",\"status\":").append(std::to_string(status)).append(",\"detail\":");
  AppendJsonString(body, detail);
  if (!field.empty()) {
    body.append(",\"field\":");
    AppendJsonString(body, field);
  }
  return response;
}

}  // namespace

bool EqualNoCase(std::string_view a, std::string_view b) {
  return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(), [](char x, char y) {
           return Lower(x) == Lower(y);
         });
}

std::string_view Name(HttpMethod method) {
  constexpr std::array<std::string_view, 7> kNames = {
      "GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OTHER"};
  return kNames[static_cast<std::size_t>(method)];
}

std::string_view HttpRequest::Header(std::string_view name) const {
  for (const auto& [key, value] : headers) {
    if (EqualNoCase(key, name)) return value;
  }
  return {};
}

std::vector<std::pair<std::string, std::string>> HttpRequest::QueryAll() const {
  std::vector<std::pair<std::string, std::string>> all;
  std::string_view rest = query;
  while (!rest.empty()) {
    std::string_view value = TakeUntil(rest, '&');
    if (value.empty()) continue;
    const std::string_view key = TakeUntil(value, '=');
    // A broken escape is kept as it was sent; the result then matches nothing that exists.
    all.emplace_back(PercentDecode(key, true).value_or(std::string(key)),
                     PercentDecode(value, true).value_or(std::string(value)));
  }
  return all;
}

std::optional<std::string> HttpRequest::Query(std::string_view name) const {
  for (auto& [key, value] : QueryAll()) {
    if (key == name) return value;
  }
  return std::nullopt;
}

const std::string& HttpRequest::PathParameter(std::string_view name) const {
  for (const auto& [key, value] : path_parameters) {
    if (key == name) return value;
  }
  LAB_CHECK(false, "no path parameter", name);
  return path_parameters.front().second;
}

std::optional<std::string> PercentDecode(std::string_view text, bool plus_is_space) {
  std::string out;
  out.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '%') {
      if (i + 2 >= text.size()) return std::nullopt;
      const int high = HexDigit(text[i + 1]);
      const int low = HexDigit(text[i + 2]);
      if (high < 0 || low < 0 || (high == 0 && low == 0)) return std::nullopt;
      out.push_back(static_cast<char>(high * 16 + low));
      i += 2;
    } else {
      out.push_back(plus_is_space && text[i] == '+' ? ' ' : text[i]);
    }
  }
  return out;
}

void AppendJsonString(std::string& out, std::string_view text) {
  constexpr std::string_view kHex = "0123456789abcdef";
  out.push_back('"');
  const bool foreign = !core::IsUtf8(text);
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      out.push_back('\\');
      out.push_back(c);
    } else if (byte < 0x20) {
      out.append("\\u00");
      out.push_back(kHex[byte >> 4]);
      out.push_back(kHex[byte & 15]);
    } else if (foreign && byte >= 0x80) {
      out.append("\\ufffd");
    } else {
      out.push_back(c);
    }
  }
  out.push_back('"');
}

void AppendReason(std::string& out, const core::Error& error) {
  out.append(",\"reason\":");
  AppendJsonString(out, error.reason.empty() ? Name(error.code) : std::string_view(error.reason));
  out.append(",\"parameters\":{");
  for (std::size_t i = 0; i < error.parameters.size(); ++i) {
    if (i > 0) out.push_back(',');
    AppendJsonString(out, error.parameters[i].name);
    out.push_back(':');
    AppendJsonString(out, error.parameters[i].value);
  }
  out.push_back('}');
}

HttpResponse Problem(int status,
                     std::string_view type,
                     std::string_view title,
                     std::string_view detail,
                     std::string_view field) {
  HttpResponse response = OpenProblem(status, type, title, detail, field);
  response.body.append(",\"reason\":");
  AppendJsonString(response.body, type);
  response.body.push_back('}');
  return response;
}

HttpResponse Problem(int status, const core::Error& error) {
  HttpResponse response =
      OpenProblem(status, Name(error.code), ReasonPhrase(status), error.message, error.field);
  AppendReason(response.body, error);
  response.body.push_back('}');
  return response;
}

HttpResponse TryAgain(int status, std::string_view detail, int seconds) {
  HttpResponse response = Problem(status, "busy", ReasonPhrase(status), detail);
  response.headers.emplace_back("Retry-After", std::to_string(seconds));
  return response;
}

std::string_view ReasonPhrase(int status) {
  using Phrase = std::pair<int, std::string_view>;
  static constexpr auto kPhrases = std::to_array<Phrase>({{200, "OK"},
                                                          {201, "Created"},
                                                          {202, "Accepted"},
                                                          {204, "No Content"},
                                                          {302, "Found"},
                                                          {303, "See Other"},
                                                          {304, "Not Modified"},
                                                          {400, "Bad Request"},
                                                          {401, "Unauthorized"},
                                                          {403, "Forbidden"},
                                                          {404, "Not Found"},
                                                          {405, "Method Not Allowed"},
                                                          {406, "Not Acceptable"},
                                                          {408, "Request Timeout"},
                                                          {409, "Conflict"},
                                                          {410, "Gone"},
                                                          {411, "Length Required"},
                                                          {412, "Precondition Failed"},
                                                          {413, "Content Too Large"},
                                                          {415, "Unsupported Media Type"},
                                                          {417, "Expectation Failed"},
                                                          {421, "Misdirected Request"},
                                                          {422, "Unprocessable Content"},
                                                          {426, "Upgrade Required"},
                                                          {428, "Precondition Required"},
                                                          {429, "Too Many Requests"},
                                                          {431, "Request Header Fields Too Large"},
                                                          {500, "Internal Server Error"},
                                                          {501, "Not Implemented"},
                                                          {503, "Service Unavailable"},
                                                          {507, "Insufficient Storage"}});
  const auto* found = std::ranges::find(kPhrases, status, &Phrase::first);
  if (found != kPhrases.end()) return found->second;
  return status < 400 ? "OK" : "Error";
}

}  // namespace faultlab::server

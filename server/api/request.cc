#include "server/api/request.h"

#include <algorithm>
#include <boost/json.hpp>
#include <charconv>
#include <utility>
#include <vector>

#include "core/types/number_text.h"
#include "core/types/utf8.h"

namespace faultlab::server {
namespace {

using core::Error;
using core::ErrorCode;

constexpr int kPageDefault = 50;
constexpr int kPageMax = 200;

/// What the refusal of a kTooMany says about when to come back.
std::string SecondsToWait(const Error& error) {
  for (const core::ErrorParameter& parameter : error.parameters) {
    if (parameter.name == "seconds") return parameter.value;
  }
  return "2";
}

}  // namespace

core::Result<std::int64_t> QueryInteger(const HttpRequest& request,
                                        std::string_view name,
                                        std::int64_t fallback,
                                        std::int64_t lo,
                                        std::int64_t hi) {
  const auto text = request.Query(name);
  if (!text) return fallback;
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text->data(), text->data() + text->size(), value);
  if (error == std::errc() && end == text->data() + text->size() && value >= lo && value <= hi) {
    return value;
  }
  return core::Refuse("whole_number_outside",
                      std::string(name),
                      {{"member", name}, {"lowest", lo}, {"highest", hi}});
}

core::Result<double> QueryNumber(
    const HttpRequest& request, std::string_view name, double fallback, double lo, double hi) {
  const auto text = request.Query(name);
  if (!text) return fallback;
  const std::optional<double> value = core::ParseNumber(*text);
  if (!value || *value < lo || *value > hi) {
    return core::Refuse(
        "number_outside", std::string(name), {{"member", name}, {"lowest", lo}, {"highest", hi}});
  }
  return *value;
}

ViewerOwner ViewerOwnerOf(const Principal& who) {
  return {.caller = who.caller_key(),
          .account_id = who.user_id,
          .sign_in = who.session_token_hash,
          .api_key_id = who.api_key_id,
          .role = std::string(Name(who.proof == Proof::kApiKey ? who.account_role : who.role))};
}

core::Result<int> PageLimit(const HttpRequest& request) {
  TRY(auto limit, QueryInteger(request, "limit", kPageDefault, 1, kPageMax));
  return static_cast<int>(limit);
}

HttpResponse Page::Answer(boost::json::array items, std::int64_t last) const {
  const bool full = items.size() == static_cast<std::size_t>(limit);
  return ListAnswer(std::move(items), full ? std::to_string(last) : "");
}

core::Result<Page> PageOf(const HttpRequest& request) {
  TRY(const auto after, QueryInteger(request, "cursor", 0, 0, INT64_MAX));
  TRY(const auto limit, PageLimit(request));
  return Page{after, limit};
}

core::Result<std::optional<std::string>> QueryWord(const HttpRequest& request,
                                                   std::string_view name,
                                                   std::span<const std::string_view> words) {
  auto word = request.Query(name);
  if (!word || std::ranges::find(words, *word) != words.end()) return word;
  std::string allowed;
  for (const std::string_view each : words) {
    if (!allowed.empty()) allowed += ", ";
    allowed += each;
  }
  return core::Refuse("word_unknown", std::string(name), {{"member", name}, {"words", allowed}});
}

core::Result<std::optional<std::string>> QuerySearch(const HttpRequest& request,
                                                     std::string_view name) {
  constexpr std::ptrdiff_t kCharactersMax = 100;
  auto text = request.Query(name);
  const auto begins = [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; };
  if (!text || std::ranges::count_if(*text, begins) <= kCharactersMax) return text;
  return core::Refuse("search_long", std::string(name));
}

core::Status OnlyQuery(const HttpRequest& request, std::string_view known) {
  const std::string words = " " + std::string(known) + " ";
  const auto is_known = [&](const std::string& name) {
    return name.find(' ') == std::string::npos && words.find(" " + name + " ") != std::string::npos;
  };
  std::vector<std::string> given;
  for (const auto& [name, value] : request.QueryAll()) {
    if (!core::IsUtf8(name) || !core::IsUtf8(value)) {
      return core::Error{
          core::ErrorCode::kInvalid, "A query parameter is not UTF-8.", "", "not_utf8"};
    }
    if (is_known(name)) {
      if (std::ranges::find(given, name) == given.end()) {
        given.push_back(name);
        continue;
      }
      return core::Refuse("query_twice", name, {{"member", name}});
    }
    constexpr std::size_t kShownMax = 64;
    const std::string shown = name.size() > kShownMax ? "(a long name)" : name;
    return core::Refuse("query_unknown", shown, {{"member", shown}});
  }
  return core::Done{};
}

core::Result<std::int64_t> PathNumber(const ApiRequest& request, std::string_view name) {
  const std::string& text = request.http.PathParameter(name);
  std::int64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error == std::errc() && end == text.data() + text.size() && number > 0) return number;
  return core::Refuse("nothing_here");
}

core::Result<std::int64_t> RequiredVersion(const ApiRequest& request) {
  std::string_view text = request.http.Header("If-Match");
  if (text.starts_with("W/")) text.remove_prefix(2);
  if (text.size() >= 2 && text.front() == '"' && text.back() == '"') {
    text = text.substr(1, text.size() - 2);
  }
  std::int64_t version = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), version);
  if (!text.empty() && error == std::errc() && end == text.data() + text.size()) return version;
  return Error{ErrorCode::kInvalid,
               "Send If-Match with the version that you saw, for example If-Match: \"3\".",
               "If-Match",
               "version_missing"};
}

boost::json::value TimeOrNull(const std::optional<WallTime>& time) {
  if (!time) return nullptr;
  return boost::json::value(Iso8601(*time));
}

boost::json::value TextOrNull(std::string_view text) {
  return text.empty() ? boost::json::value(nullptr) : boost::json::value(text);
}

HttpResponse JsonResponse(const boost::json::value& value, int status) {
  HttpResponse response;
  response.status = status;
  response.body = boost::json::serialize(value);
  return response;
}

HttpResponse JsonUntilSettled(const boost::json::value& value, bool settled) {
  HttpResponse response = JsonResponse(value);
  response.unsettled = !settled;
  return response;
}

HttpResponse JsonText(std::string text) {
  HttpResponse response;
  response.body = std::move(text);
  return response;
}

HttpResponse NoContent() {
  HttpResponse response;
  response.status = 204;
  return response;
}

core::Result<HttpResponse> Spooled(std::unique_ptr<Spool> bytes, std::string_view content_type) {
  if (!bytes->status().ok()) return bytes->status().error();
  HttpResponse response;
  response.content_type = content_type;
  if (bytes->in_memory()) {
    response.body = std::move(*bytes).TakeMemory();
  } else {
    response.spool = std::move(bytes);
  }
  return response;
}

core::Result<HttpResponse> Download(std::unique_ptr<Spool> bytes,
                                    std::string_view content_type,
                                    std::string_view file_name) {
  TRY(auto response, Spooled(std::move(bytes), content_type));
  response.headers.emplace_back("Content-Disposition", ContentDisposition("attachment", file_name));
  return response;
}

std::string ContentDisposition(std::string_view kind, std::string_view file_name) {
  constexpr std::string_view kHex = "0123456789ABCDEF";
  std::string plain;
  std::string encoded;
  for (const char c : file_name) {
    const auto byte = static_cast<unsigned char>(c);
    const bool safe = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                      c == '-' || c == '_' || c == '.';
    if (safe) {
      plain += c;
      encoded += c;
      continue;
    }
    const bool continues = (byte & 0xC0U) == 0x80U;  // of a character that has its '_' already
    if (!continues) plain += '_';
    encoded += '%';
    encoded += kHex[byte >> 4];
    encoded += kHex[byte & 0xFU];
  }
  return std::string(kind) + "; filename=\"" + plain + "\"; filename*=UTF-8''" + encoded;
}

int HttpStatus(core::ErrorCode code) {
  switch (code) {
    case core::ErrorCode::kInvalid:
      return 400;
    case core::ErrorCode::kNotFound:
      return 404;
    case core::ErrorCode::kConflict:
    case core::ErrorCode::kStale:
      return 409;
    case core::ErrorCode::kUnauthorized:
      return 401;
    case core::ErrorCode::kForbidden:
      return 403;
    case core::ErrorCode::kBusy:
      return 503;
    case core::ErrorCode::kTooMany:
      return 429;
    case core::ErrorCode::kTooLarge:
      return 413;
    case core::ErrorCode::kUnavailable:
      return 503;
  }
  return 500;
}

HttpResponse ProblemOf(const core::Error& error) {
  const int status = HttpStatus(error.code);
  HttpResponse response = Problem(status, error);
  if (status == 429) response.headers.emplace_back("Retry-After", SecondsToWait(error));
  if (status == 503) response.headers.emplace_back("Retry-After", "2");
  if (status == 401) response.headers.emplace_back("WWW-Authenticate", "Bearer");
  return response;
}

HttpResponse ListAnswer(boost::json::array items, const std::string& next) {
  boost::json::object out{{"items", std::move(items)}, {"next_cursor", nullptr}};
  if (!next.empty()) out["next_cursor"] = next;
  return JsonResponse(out);
}

HttpResponse Versioned(HttpResponse response, std::int64_t version) {
  response.headers.emplace_back("ETag", "\"" + std::to_string(version) + "\"");
  return response;
}

HttpResponse Png(std::string png, std::string_view name) {
  HttpResponse response;
  response.content_type = "image/png";
  response.body = std::move(png);
  response.headers.emplace_back("Content-Disposition", ContentDisposition("inline", name));
  return response;
}

core::Result<std::optional<WallTime>> QueryTime(const HttpRequest& request, std::string_view name) {
  const auto text = request.Query(name);
  if (!text) return std::optional<WallTime>{};
  TRY(const auto time, ParseIso8601(*text, std::string(name)));
  return std::optional(time);
}

}  // namespace faultlab::server

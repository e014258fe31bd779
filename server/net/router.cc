#include "server/net/router.h"

#include <utility>

namespace faultlab::server {
namespace {

std::string_view TakeSegment(std::string_view& rest) {
  const std::size_t slash = rest.find('/');
  const std::string_view segment = rest.substr(0, slash);
  rest = slash == std::string_view::npos ? std::string_view() : rest.substr(slash + 1);
  return segment;
}

struct Score {
  bool matched = false;
  int literals = 0;   ///< the pattern with more literal segments wins
  bool open = false;  ///< "/*" is used only if no other pattern matches
};

/// One segment: a literal, or prefix{name}suffix.
bool MatchSegment(std::string_view pattern,
                  std::string_view segment,
                  std::vector<std::pair<std::string_view, std::string>>& parameters,
                  int& literals) {
  const std::size_t open = pattern.find('{');
  if (open == std::string_view::npos) {
    ++literals;
    return pattern == segment;
  }
  const std::size_t close = pattern.find('}', open);
  const std::string_view prefix = pattern.substr(0, open);
  const std::string_view suffix = pattern.substr(close + 1);
  if (segment.size() <= prefix.size() + suffix.size()) return false;
  if (!segment.starts_with(prefix) || !segment.ends_with(suffix)) return false;
  segment.remove_prefix(prefix.size());
  segment.remove_suffix(suffix.size());
  auto decoded = PercentDecode(segment, false);
  if (!decoded) return false;
  parameters.emplace_back(pattern.substr(open + 1, close - open - 1), std::move(*decoded));
  return true;
}

Score MatchPath(std::string_view pattern,
                std::string_view path,
                std::vector<std::pair<std::string_view, std::string>>& parameters) {
  Score score;
  if (!path.starts_with('/')) return score;
  pattern.remove_prefix(1);
  path.remove_prefix(1);
  for (;;) {
    if (pattern == "*") return {true, score.literals, true};
    const bool pattern_last = pattern.find('/') == std::string_view::npos;
    const bool path_last = path.find('/') == std::string_view::npos;
    if (!MatchSegment(TakeSegment(pattern), TakeSegment(path), parameters, score.literals)) {
      return score;
    }
    if (pattern_last != path_last) return score;
    if (pattern_last) break;
  }
  score.matched = true;
  return score;
}

bool Answers(HttpMethod route, HttpMethod asked) {
  return route == asked || (route == HttpMethod::kGet && asked == HttpMethod::kHead);
}

}  // namespace

void Router::Add(Route route) {
  if (route.method == HttpMethod::kGet && route.pattern.find_first_of("{*") == std::string::npos) {
    literal_gets_.emplace(route.pattern, routes_.size());
  }
  routes_.push_back(std::move(route));
}

Router::Match Router::Find(HttpRequest& request) const {
  Match match;
  if (Answers(HttpMethod::kGet, request.method)) {
    const auto literal = literal_gets_.find(std::string(request.path));
    if (literal != literal_gets_.end()) {
      match.route = &routes_[literal->second];
      return match;
    }
  }
  Score best;
  std::vector<std::pair<std::string_view, std::string>> parameters;
  for (const Route& route : routes_) {
    parameters.clear();
    const Score score = MatchPath(route.pattern, request.path, parameters);
    if (!score.matched) continue;
    if (!Answers(route.method, request.method)) {
      if (score.open) continue;
      if (!match.allow.empty()) match.allow.append(", ");
      match.allow.append(Name(route.method));
      if (route.method == HttpMethod::kGet) match.allow.append(", HEAD");
      continue;
    }
    const bool better = match.route == nullptr || (best.open && !score.open) ||
                        (best.open == score.open && score.literals > best.literals);
    if (!better) continue;
    best = score;
    match.route = &route;
    request.path_parameters.swap(parameters);
  }
  // A path that exists for another method is 405, also where a "/*" route would match.
  if (match.route != nullptr && best.open && !match.allow.empty()) match.route = nullptr;
  if (match.route != nullptr) match.allow.clear();
  return match;
}

}  // namespace faultlab::server

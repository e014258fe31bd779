// Runs every operation of the API's description on a running server: first correctly, with real
// ids, as right_use.txt says; then by every role, with ids of other users and of nothing, and with
// every mistake that its parameters and its body's schema suggest. Each answer is checked against
// the description.
#include <gtest/gtest.h>

#include <algorithm>
#include <boost/json.hpp>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <regex>
#include <sstream>

#include "tests/support/await.h"
#include "tests/support/paths.h"
#include "tests/system/contract/bad_bodies.h"
#include "tests/system/contract/contract_world.h"

namespace faultlab::tests {
namespace {

namespace json = boost::json;
const std::string kGzip = "Content-Type: application/gzip\r\n";

std::string RecordingCsv() {
  std::string text = "t_s,uc_v,um_v\n";
  for (int i = 0; i < 700; ++i) {
    const double uc_v = (i * 7919 / 13) % 2 == 0 ? 2.0 : 3.0;
    text += std::to_string(i * 0.01) + "," + std::to_string(uc_v) + "," +
            std::to_string(2.4 * uc_v) + "\n";
  }
  return text;
}

/// Whether `value` has all members of `wanted`, and lists as long as its lists.
bool Has(const json::value& value, const json::value& wanted) {
  if (const json::object* members = wanted.if_object()) {
    return value.is_object() && std::ranges::all_of(*members, [&](const auto& member) {
             const json::value* found = value.as_object().if_contains(member.key());
             return found != nullptr && Has(*found, member.value());
           });
  }
  if (const json::array* items = wanted.if_array()) {
    return value.is_array() &&
           std::ranges::equal(
               value.as_array(), *items, [](const auto& a, const auto& b) { return Has(a, b); });
  }
  return value == wanted;
}

std::string Upper(std::string_view name) {
  std::string upper(name);
  for (char& c : upper) c = static_cast<char>(std::toupper(c));
  return upper;
}

/// Cuts what follows `mark` off `text`; "" where the mark is not.
std::string CutFrom(std::string& text, std::string_view mark) {
  const std::size_t at = text.rfind(mark);
  if (at == std::string::npos) return {};
  std::string rest = text.substr(at + mark.size());
  text.resize(at);
  return rest;
}

/// The word at the begin of `text`, which is cut off.
std::string NextWord(std::string& text) {
  const std::size_t space = std::min(text.find(' '), text.size());
  std::string word = text.substr(0, space);
  text.erase(0, std::min(space + 1, text.size()));
  return word;
}

class Contract : public ContractWorld {
 protected:
  /// What right_use.txt says, line by line.
  void RightUse();
  void RightUseOf(std::string line);
  void Policies();
  /// Whom each operation lets in, as rights.txt says.
  void Rights();
  /// A request of right_use.txt, or to something that does not exist.
  struct Use {
    std::string request;
    std::string body{};
    std::string headers{};
  };
  /// @param is_there  what it asks for exists: "no such thing" is a refusal, too
  bool IsRefused(const std::string& who, const Use& use, bool is_there);
  void Mistakes();
  void Report();

 private:
  /// A text of right_use.txt with what its $names mean.
  std::string Filled(const std::string& text) const;
  std::string MeaningOf(const std::string& path) const;
  void Mistake(const std::string& method,
               const std::string& pattern,
               const json::object& operation);
  void WrongIds(const std::string& method, const std::string& pattern);
  void WrongQueries(const std::string& pattern, const json::object& operation);
  void WrongBodies(const std::string& method,
                   const std::string& pattern,
                   const json::object& operation);

  /// With whom and with which address the mistakes of an operation are made.
  struct Known {
    std::string who = "admin";
    std::string target;
  };
  Known KnownOf(const std::string& pattern) const {
    const auto found = known_.find(pattern);
    if (found != known_.end()) return found->second;
    return {"admin", std::regex_replace(pattern, std::regex(R"(\{\w+\})"), "1")};
  }

  std::map<std::string, Known> known_;  ///< by pattern
  std::map<std::string, Use> uses_;     ///< "PATCH /api/v1/runs/{id}" -> the last that was granted
  json::object answers_{{"recording", RecordingCsv()}};
};

std::string Contract::MeaningOf(const std::string& path) const {
  std::istringstream steps(path);
  std::string step;
  std::getline(steps, step, '.');
  json::value at = answers_.at(step);
  if (at.is_object() && path == step) return server::Id(at);
  while (std::getline(steps, step, '.')) {
    const std::size_t is = step.find('=');
    if (is != std::string::npos) {
      const auto& items = at.as_array();
      at = json::value(*std::ranges::find_if(items, [&](const json::value& item) {
        return server::Text(item, step.substr(0, is)) == step.substr(is + 1);
      }));
    } else {
      at = json::value(at.is_array() ? at.at(std::stoul(step)) : at.at(step));
    }
  }
  return server::Id(json::object{{"id", at}});
}

std::string Contract::Filled(const std::string& text) const {
  static const std::regex kName(R"(\$in\((\d+)\)|\$(\w+(\.[\w=]+)*)(#?))");
  std::string filled;
  std::size_t end = 0;
  for (std::sregex_iterator each(text.begin(), text.end(), kName), last; each != last; ++each) {
    filled += text.substr(end, static_cast<std::size_t>(each->position()) - end);
    end = static_cast<std::size_t>(each->position() + each->length());
    if ((*each)[1].matched) {
      filled += In(std::chrono::minutes(std::stoi((*each)[1])));
    } else {
      const std::string meaning = MeaningOf((*each)[2]);
      filled += (*each)[4].length() > 0 ? meaning.substr(meaning.find('=') + 1) : meaning;
    }
  }
  return filled + text.substr(end);
}

void Contract::RightUseOf(std::string line) {
  std::string expected = CutFrom(line, " => ");
  const std::string name = CutFrom(expected, " as ");
  const bool eventually = expected.ends_with(" eventually");
  if (eventually) expected.resize(expected.size() - std::string(" eventually").size());
  const int status = std::stoi(NextWord(expected));
  const bool remembered = line.starts_with('*');
  if (remembered) line.erase(0, 1);
  line = Filled(line);
  const std::string who = NextWord(line);
  const std::string method = NextWord(line);
  const std::string target = NextWord(line);
  std::string headers;
  if (line.starts_with("if=")) headers = server::IfMatch(std::stoi(NextWord(line).substr(3)));
  if (line.starts_with("csv:")) {
    headers += server::kCsv;
    line = std::regex_replace(line.substr(4), std::regex(R"(\\n)"), "\n");
  }
  const std::string request = method + " " + target;
  const std::string pattern = description_.PatternOf(Split(request).second);
  json::object answer;
  const auto is_as_expected = [&] {
    answer = Expect(status, who, request, line, headers);
    return expected.empty() || Has(answer, json::parse(expected));
  };
  EXPECT_TRUE(eventually ? tests::Await(is_as_expected) : is_as_expected())
      << request << ": " << json::serialize(answer).substr(0, 500) << " is not " << expected;
  if (!name.empty()) answers_[name] = std::move(answer);
  if (remembered) known_[pattern] = {who, target};
  if (status < 300) uses_[method + " " + pattern] = {request, line, headers};
}

void Contract::RightUse() {
  std::ifstream lines(tests::InSource("tests/system/contract/right_use.txt"));
  ASSERT_TRUE(lines.good());
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line.starts_with('#')) continue;
    SCOPED_TRACE(line);
    RightUseOf(line);
    if (HasFailure()) return;  // what follows would be about its ids
  }
}

/// What one answer says is sent back in the next request: a tag, and a whole policy.
void Contract::Policies() {
  json::object policy = Expect(200, "guest", "GET policy");
  const std::string version = server::IfMatch(policy.at("version").as_int64());
  policy.erase("version");
  policy["live_bookings_max"] = 5;
  const std::string wanted = json::serialize(policy);
  Expect(403, "operator", "PUT policy", wanted, version);
  Expect(200, "admin", "PUT policy", wanted, version);
  Expect(409, "admin", "PUT policy", wanted, version);
  const HttpAnswer benches = Call("guest", "GET benches");
  const std::string known = "If-None-Match: " + std::string(benches.Header("ETag")) + "\r\n";
  Expect(304, "guest", "GET benches", {}, known);
  const std::string of_benches = "rig-classes/bench/policy";
  policy = Expect(200, "ann", "GET " + of_benches);
  policy.erase("version");
  Expect(200, "admin", "PUT " + of_benches, json::serialize(policy), server::IfMatch(0));
  Expect(204, "admin", "DELETE " + of_benches);
  known_["/api/v1/rig-classes/{rig_class}/policy"] = {"admin", of_benches};
}

bool Contract::IsRefused(const std::string& who, const Use& use, bool is_there) {
  const int status = Call(who, use.request, use.body, use.headers).status;
  return status == 401 || status == 403 || (is_there && status == 404);
}

void Contract::Rights() {
  std::ifstream lines(tests::InSource("tests/system/contract/rights.txt"));
  std::map<std::string, std::string> expected;
  for (std::string line; std::getline(lines, line);) {
    const std::size_t colon = line.find(": ");
    if (!line.starts_with('#') && colon != std::string::npos) {
      expected[line.substr(0, colon)] = line.substr(colon + 2);
    }
  }
  for (const auto& [path, operations] : description_.document().at("paths").as_object()) {
    const std::string pattern(path);
    for (const auto& [name, operation] : operations.as_object()) {
      const std::string method = Upper(name);
      if (pattern.ends_with("/auth/logout")) continue;
      const bool reads = method == "GET";
      const std::string nothing = std::regex_replace(pattern, std::regex(R"(\{\w+\})"), "0");
      const char* body = operation.as_object().contains("requestBody") ? "[]" : "";
      const Use of_nothing{method + " " + nothing, body, server::IfMatch(99)};
      const auto known = uses_.find(method + " " + pattern);
      const Use used = known == uses_.end() ? of_nothing : known->second;
      const Use read{"GET " + KnownOf(pattern).target};
      const std::string key =
          method + " " + (pattern.starts_with("/api/v1/") ? pattern.substr(8) : pattern);
      const std::string whom = " " + expected[key] + " ";
      std::string words;
      for (const auto& [who, person] : people_) {
        const bool may = whom == " anybody " || whom.find(" " + who + " ") != std::string::npos;
        const bool is_refused = reads ? IsRefused(who, read, true)
                                : may ? IsRefused(who, of_nothing, false)
                                      : IsRefused(who, used, true);
        if (!is_refused) words += " " + who;
      }
      if (std::ranges::count(words, ' ') == std::ssize(people_)) words = " anybody";
      EXPECT_EQ(key + ":" + (words.empty() ? " nobody" : words),
                key + ":" + whom.substr(0, whom.size() - 1));
      expected.erase(key);
    }
  }
  for (const auto& [key, whom] : expected) ADD_FAILURE() << "no such operation: " << key;
}

void Contract::WrongIds(const std::string& method, const std::string& pattern) {
  const Known known = KnownOf(pattern);
  static const std::regex kId(R"(\{\w+\})");
  for (std::sregex_iterator id(pattern.begin(), pattern.end(), kId), last; id != last; ++id) {
    // The segment of the address that stands for this {id}.
    const auto segments = std::count(pattern.begin(), pattern.begin() + id->position(), '/');
    const std::string target = Split(method + " " + known.target).second;
    std::size_t from = 0;
    for (std::ptrdiff_t n = 0; n < segments; ++n) from = target.find('/', from) + 1;
    const std::size_t to = std::min(target.find('/', from), target.find('?', from));
    const std::string after = id->suffix().str().substr(0, id->suffix().str().find('/'));
    for (const std::string& wrong : {std::string("0"),
                                     std::string("-1"),
                                     std::string("99999999999999999999999"),
                                     std::string("nope"),
                                     std::string("..%2f..%2fetc%2fpasswd"),
                                     std::string("%27%20OR%201=1"),
                                     std::string("%F0%9F%92%A9"),
                                     std::string(300, 'x')}) {
      std::string request = method + " " + target.substr(0, from) + wrong + after;
      if (to != std::string::npos) request += target.substr(to);
      const HttpAnswer answer = Call(known.who, request);
      EXPECT_GE(answer.status, 400) << request;
    }
  }
}

void Contract::WrongQueries(const std::string& pattern, const json::object& operation) {
  const Known known = KnownOf(pattern);
  const std::string target = known.target.substr(0, known.target.find('?'));
  const auto ask = [&](const std::string& query) {
    return Call(known.who, "GET " + target + "?" + query).status;
  };
  (void)ask("no_such_parameter=1");
  const json::value* parameters = operation.if_contains("parameters");
  if (parameters == nullptr) return;
  for (const json::value& parameter : parameters->as_array()) {
    if (parameter.at("in") != "query") continue;
    const std::string name(parameter.at("name").as_string());
    for (const char* wrong :
         {"", "x", "-1", "1e9", "9999999999999999999999", "%00", "%ff", "1;DROP", "../.."}) {
      (void)ask(name + "=" + wrong);
    }
    if (name == "limit" || name == "since" || name == "from") {
      EXPECT_EQ(ask(name + "=x"), 400) << pattern << " " << name;
    }
    if (name == "limit") {
      EXPECT_EQ(ask("limit=1000000"), 400) << pattern;
    }
    if (name == "cursor") {
      EXPECT_EQ(ask("cursor=garbage"), 400) << pattern;
    }
  }
}

void Contract::WrongBodies(const std::string& method,
                           const std::string& pattern,
                           const json::object& operation) {
  const json::value* request = operation.if_contains("requestBody");
  if (request == nullptr) return;
  const Known known = KnownOf(pattern);
  const std::string target = known.target.substr(0, known.target.find('?'));
  const json::object& content = request->at("content").as_object();
  const auto send = [&](const std::string& body, const std::string& headers) {
    return Call(known.who, method + " " + target, body, headers + server::IfMatch(99)).status;
  };
  if (content.contains("text/csv")) {
    for (const char* body : {"\x01\x02", "a,b\n1", "t_s,uc_v,um_v\n0,1\n", "login\n\n\n,,,"}) {
      EXPECT_GE(send(body, server::kCsv), 400) << pattern << " " << body;
      EXPECT_GE(send(body, kGzip), 400) << pattern << " " << body;
    }
    return;
  }
  if (content.contains("application/x-www-form-urlencoded")) {  // of a page of another site
    for (const char* body : {"", "x=1", "state=%00&id_token=%zz", "\x01\x02", "iss&iss"}) {
      EXPECT_GE(send(body, "Origin: https://elsewhere.example\r\n"), 400) << pattern << " " << body;
    }
    return;
  }
  const json::object& media = content.at("application/json").as_object();
  const json::value* example = media.if_contains("example");
  const json::object good =
      example != nullptr && example->is_object() ? example->as_object() : json::object{};
  EXPECT_FALSE(description_.CheckRequest(method, pattern, json::serialize(good)))
      << pattern << ": its example does not fit its schema";
  EXPECT_EQ(send("x=1", "Content-Type: application/x-www-form-urlencoded\r\n"), 415) << pattern;
  EXPECT_EQ(send(std::string(std::size_t{5} << 20, ' '), ""), 413) << pattern;
  for (const BadBody& bad : BadBodies(description_.document(), media.at("schema"), good)) {
    if (bad.text.empty()) continue;
    // The server must refuse what the schema refuses; what the schema cannot express, the server
    // may accept.
    const bool refused = description_.CheckRequest(method, pattern, bad.text).has_value();
    if (!refused) continue;
    EXPECT_GE(send(bad.text, ""), 400) << method << " " << pattern << ": " << bad.mistake << "\n"
                                       << bad.text.substr(0, 500);
  }
}

void Contract::Mistake(const std::string& method,
                       const std::string& pattern,
                       const json::object& operation) {
  const std::string request = method + " " + KnownOf(pattern).target;
  // Without a matching If-Match and without a body, a request changes nothing.
  for (const char* who : {"guest", "bob", "ann", "robot", "reader", "teacher", "operator"}) {
    if (pattern.ends_with("/auth/logout") || method == "POST") break;
    (void)Call(who, request, {}, server::IfMatch(99));
  }
  if (method == "POST" && !pattern.ends_with("/runs") && !pattern.ends_with("/auth/logout")) {
    for (const char* who : {"guest", "reader", "bob"}) {
      (void)Call(who, request, "[]");
    }
  }
  WrongIds(method, pattern);
  if (method == "GET") WrongQueries(pattern, operation);
  if (!pattern.ends_with("/auth/logout")) WrongBodies(method, pattern, operation);
}

void Contract::Mistakes() {
  for (const auto& [path, operations] : description_.document().at("paths").as_object()) {
    for (const auto& [name, operation] : operations.as_object()) {
      Mistake(Upper(name), std::string(path), operation.as_object());
    }
  }
  Expect(204, "bob", "POST auth/logout", "{}");
  EXPECT_EQ(Call("guest", "GET /healthz").status, 200) << "and it lives on";
}

void Contract::Report() {
  int described = 0;
  int reached = 0;
  for (const auto& [path, operations] : description_.document().at("paths").as_object()) {
    for (const auto& [name, operation] : operations.as_object()) {
      const std::string key = Upper(name) + " " + std::string(path);
      const auto seen = seen_.find(key);
      ASSERT_NE(seen, seen_.end()) << key << " was never asked";
      std::string missing;
      bool succeeded = false;
      for (const auto& [status, response] : operation.at("responses").as_object()) {
        const int number = std::stoi(std::string(status));
        ++described;
        if (seen->second.contains(number)) {
          ++reached;
          succeeded = succeeded || number < 300;
        } else {
          missing += " " + std::to_string(number);
        }
      }
      // Signing in at a provider is tested by oidc.test.js, which has providers.
      const bool elsewhere =
          path.starts_with("/api/v1/auth/oidc/") || path == "/api/v1/auth/identities/{id}" ||
          path == "/api/v1/lti/login" || path == "/api/v1/lti/launch" ||
          path == "/api/v1/lti/window" || path.starts_with("/api/v1/lti/register/") ||
          key == "POST /api/v1/courses/{id}/rosters";
      EXPECT_TRUE(succeeded || elsewhere || path == "/api/v1/bookings/{id}/claim" ||
                  path == "/api/v1/sessions/{id}/extend" ||  // a session extends itself
                  path == "/api/v1/rigs/{id}/clear-trip" || path == "/api/v1/rigs/{id}/adopt" ||
                  path == "/api/v1/rigs/{id}/relays/{line}/replaced")
          << key << " never did what it is for";
      if (!missing.empty()) std::printf("  not reached: %s%s\n", key.c_str(), missing.c_str());
    }
  }
  std::printf("%d calls; %d of %d described answers reached\n", calls_, reached, described);
}

TEST_F(Contract, EveryOperationKeepsItsDescriptionInGoodAndInBadUse) {
  RightUse();
  ASSERT_FALSE(HasFailure());
  Policies();
  Rights();
  Mistakes();
  Report();
}

}  // namespace
}  // namespace faultlab::tests

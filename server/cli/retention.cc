#include "server/cli/retention.h"

#include <boost/json.hpp>
#include <chrono>

#include "server/api/iso8601.h"
#include "server/cli/console.h"
#include "server/json/list_of.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

json::object ToJson(const RetentionReport& report, bool dry_run) {
  const auto item_json = [](const Expired& item) {
    return json::object{{"kind", item.kind},
                        {"id", item.id},
                        {"owner", item.owner},
                        {"rule", item.rule},
                        {"created_at", Iso8601(item.created_at)}};
  };
  return {{"dry_run", dry_run},
          {"items", ListOf(report.items, item_json)},
          {"news", report.news},
          {"stale_links_and_sign_ins", report.stale},
          {"unnamed_benches", report.benches}};
}

std::string ToText(const RetentionReport& report, bool dry_run) {
  std::string out;
  for (const Expired& item : report.items) {
    out += item.kind + "\t" + item.id + "\t" + item.owner + "\t" + item.rule + "\t" +
           Iso8601(item.created_at) + "\n";
  }
  return out + (dry_run ? "would delete " : "deleted ") + std::to_string(report.items.size()) +
         " recordings and jobs, " + std::to_string(report.news) + " news, " +
         std::to_string(report.stale) + " links and sign-ins, " + std::to_string(report.benches) +
         " benches that nothing names\n";
}

}  // namespace

int RunRetention(const RetentionOptions& options) {
  const auto database = OpenExisting(options.target);
  if (!database) return Fail(database.error());
  const auto now = std::chrono::floor<std::chrono::milliseconds>(std::chrono::system_clock::now());
  const auto report = Retain(*database.value(), options.rules, now, !options.dry_run);
  if (!report) return Fail(report.error());
  return Print(options.json ? json::serialize(ToJson(report.value(), options.dry_run)) + "\n"
                            : ToText(report.value(), options.dry_run));
}

}  // namespace faultlab::server

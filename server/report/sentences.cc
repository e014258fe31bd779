#include "server/report/sentences.h"

#include <regex>
#include <utility>

namespace faultlab::server {
namespace {

using Form = std::pair<const char*, std::string ReportWords::*>;

template <std::size_t N>
std::string Said(const ReportWords& words, const std::string& text, const Form (&forms)[N]) {
  for (const auto& [form, said] : forms) {
    std::smatch found;
    if (!std::regex_search(text, found, std::regex(form))) continue;
    return Fill(words.*said, {found[1].str(), found[2].str()});
  }
  return text;
}

}  // namespace

std::string QuestionIn(const ReportWords& words, const std::string& question) {
  static const Form kForms[] = {
      {R"(^(\S+) outside its band\?$)", &ReportWords::outside},
      {R"(^(\S+) and (\S+) in opposite directions\?$)", &ReportWords::opposite},
      {R"(^(\S+) and (\S+) in the same direction\?$)", &ReportWords::same_way}};
  return Said(words, question, kForms);
}

std::string ReasonIn(const ReportWords& words, const std::string& reason) {
  static const Form kForms[] = {
      {"^too few samples after the alarm$", &ReportWords::too_early},
      {"^something has changed just before the end: ", &ReportWords::too_late},
      {"^something may have changed a little: ", &ReportWords::ends_too_soon},
      {"^something has changed; what, is being worked out$", &ReportWords::worked_out},
      {R"(^no single component explains the record: beside (\S+) also (.+)$)",
       &ReportWords::beside},
      {"^no single component explains the record$", &ReportWords::no_single},
      {R"(^(\w+) does not follow the motor: its sensor)", &ReportWords::sensor_lost},
      {R"(^(\w+) reads (\S+) times what it should: its sensor)", &ReportWords::sensor_gain},
      {R"(^(\w+) reads (\S+ \w+) too much: its sensor)", &ReportWords::sensor_high},
      {R"(^(\w+) reads (\S+ \w+) too little: its sensor)", &ReportWords::sensor_low},
      {R"(^dry friction takes (\S+) mNm, (\S+) before:)", &ReportWords::friction},
      {R"(^the winding has moved by (\S+) %, as that of a rig that warms up or runs in does$)",
       &ReportWords::warmed},
      {"^two components have changed together", &ReportWords::two}};
  return Said(words, reason, kForms);
}

}  // namespace faultlab::server

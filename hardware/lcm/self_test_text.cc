#include "hardware/lcm/self_test_text.h"
#include "core/types/number_text.h"

#include <cmath>

namespace faultlab::hardware {
namespace {

std::string JsonText(const std::string& text) {
  std::string json = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      json += '\\';
      json += c;
    } else if (static_cast<unsigned char>(c) < 0x20) {
      const std::string escape = core::Format("\\u%04x", static_cast<unsigned>(c));
      json += escape;
    } else {
      json += c;
    }
  }
  return json + "\"";
}

std::string JsonNumber(double value) {
  if (!std::isfinite(value)) return "null";
  return core::Format("%.9g", value);
}

std::string JsonPart(core::Component component, double value, const std::string& line) {
  const std::string name = component.exists() ? std::string(core::Name(component)) : "";
  return "{\"component\":" + JsonText(name) + ",\"value\":" + JsonNumber(value) +
         ",\"line\":" + JsonText(line);
}

std::string JsonEnd(const std::string& text) {
  return (text.empty() ? "" : ",\"text\":" + JsonText(text)) + "}";
}

std::string JsonOf(const ContactReport& contacts) {
  std::string json = "{\"positions\":[";
  for (const ContactFinding& finding : contacts.positions) {
    if (json.back() == '}') json += ',';
    json += JsonPart(finding.component, finding.value, finding.line) +
            ",\"contact\":" + JsonText(std::string(Name(finding.contact))) +
            ",\"um_expected_v\":" + JsonNumber(finding.um_expected_v) +
            ",\"um_seen_v\":" + JsonNumber(finding.um_seen_v) +
            ",\"ia_expected_a\":" + JsonNumber(finding.ia_expected_a) +
            ",\"ia_seen_a\":" + JsonNumber(finding.ia_seen_a) + JsonEnd(finding.text);
  }
  return json + "],\"nominal\":" + JsonText(contacts.nominal) +
         ",\"ok\":" + (contacts.ok ? "true" : "false") + "}";
}

std::string Part(core::Component component, double value, const std::string& line) {
  const bool known = component.exists();
  return core::Format("%-4s %10.4g %-6s %-5s",
                      known ? std::string(core::Name(component)).c_str() : "",
                      value,
                      known ? std::string(core::Unit(component)).c_str() : "",
                      line.c_str());
}

std::string Reading(const char* name, const char* unit, double expected, double seen) {
  if (std::isnan(expected)) return "";
  return core::Format("  %s %.3g of %.3g %s", name, seen, expected, unit);
}

std::string WordOf(const ContactFinding& finding) {
  if (finding.contact == Contact::kWrong) return "WRONG: " + finding.text;
  return finding.contact == Contact::kRecognised
             ? "recognised"
             : "read-back only: it has no effect that can be seen";
}

}  // namespace

std::string TableOf(const SelfTestReport& report, const ContactReport* contacts) {
  std::string table;
  for (const SelfTestPosition& position : report.positions) {
    table += Part(position.component, position.value, position.line) +
             (position.ok ? " ok " : " FAILED ") + position.text + "\n";
  }
  table += report.ok ? "all positions answer\n" : "SELF-TEST FAILED\n";
  if (contacts == nullptr) return table;
  table += "\nBy their effect (seen of expected):\n";
  for (const ContactFinding& finding : contacts->positions) {
    table += Part(finding.component, finding.value, finding.line) + " " + WordOf(finding) +
             Reading("um", "V", finding.um_expected_v, finding.um_seen_v) +
             Reading("ia", "A", finding.ia_expected_a, finding.ia_seen_a) + "\n";
  }
  if (!contacts->nominal.empty()) table += "nominal WRONG: " + contacts->nominal + "\n";
  return table + (contacts->ok ? "all contacts answer\n" : "CONTACTS FAILED\n");
}

std::string JsonOf(const SelfTestReport& report, const ContactReport* contacts) {
  std::string json = "{\"positions\":[";
  for (const SelfTestPosition& position : report.positions) {
    if (json.back() == '}') json += ',';
    json += JsonPart(position.component, position.value, position.line) +
            ",\"ok\":" + (position.ok ? "true" : "false") + JsonEnd(position.text);
  }
  json += std::string("],\"ok\":") + (report.ok ? "true" : "false");
  if (contacts != nullptr) json += ",\"contacts\":" + JsonOf(*contacts);
  return json + "}\n";
}

}  // namespace faultlab::hardware

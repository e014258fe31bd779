#pragma once

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>

namespace faultlab::server {

enum class Language { kEnglish, kSerbian, kSerbianCyrillic };

/// "en", "sr" (Latin script), "sr-Cyrl".
std::optional<Language> ParseLanguage(std::string_view name);

/// All texts of a report in one language. {0}, {1}.. are filled in.
struct ReportWords {
  char decimal_sign = '.';  ///< between the whole part of a number and its decimals
  std::string report;       ///< the kind of document, above its title
  std::string run;
  std::string made_by;
  std::string guest;
  std::string time;
  std::string rig;
  std::string uploaded;
  std::string bench;
  std::string description;  ///< "{0}, description {1}": bench's title and id
  std::string state;
  std::string state_finished;
  std::string state_stopped;
  std::string state_failed;
  std::string state_interrupted;
  std::string samples;  ///< "{0} samples, {1} apart: {2} s"
  std::string samples_name;
  std::string settings;
  std::string excitation;
  std::string control;
  std::string control_steps;  ///< "{0} to {1} rpm, {2} s each, from {3} s on"
  std::string control_ramp;
  std::string control_prbs;
  std::string control_made_up;
  std::string control_since;  ///< "{0} since {1} s"
  std::string control_deviation;
  std::string control_judged;  ///< "integral {0} rad, steady {1} rpm, from {2} s on"
  std::string control_alone;
  std::string control_never;
  std::string replay_of;
  std::string calibration;
  std::string calibrated_on_run;  ///< "from this recording, {0} to {1} s"
  std::string calibrated_before;  ///< "of {0}": stored with the rig
  std::string calibration_none;
  std::string delta;
  std::string noise;
  std::string false_alarms;  ///< "{0} a day over all tests"
  std::string false_alarms_name;

  std::string faults;  ///< heading
  std::string faults_none;
  std::string sealed;
  std::string faults_more;  ///< "and {0} more, in the JSON export"
  std::string at_time;      ///< columns
  std::string at_sample;
  std::string component;
  std::string value;
  std::string rig_says;
  std::string confirmed;
  std::string refused;
  std::string unconfirmed;
  std::string nominal;  ///< "nominal"

  std::string verdict;
  std::string verdict_fault;  ///< "Fault: {0}"
  std::string or_word;
  std::string no_component;
  std::string verdict_unknown;
  std::string verdict_sensor;  ///< "{0}": a channel
  std::string verdict_nominal;
  std::string verdict_set_back;  ///< "Fault: R9 or R12; set back" of {0}
  std::string verdict_not_excited;
  std::string verdict_none;
  std::string unsettled;
  std::string detected;
  std::string detected_again;  ///< of a further change of the same fault
  std::string earlier;
  std::string earlier_is;   ///< "{0}, detected at {1} s, until {2} s"
  std::string detected_at;  ///< "at {0} s by {1}"
  std::string detector_residual;
  std::string detector_cusum;
  std::string detector_glr;    ///< over {0} samples
  std::string began_at;        ///< ", began at about {0} s"
  std::string standard_error;  ///< "{0} (standard error); nominal {1}"
  std::string bound;           ///< "{0}; nominal {1}"
  std::string group;
  std::string explains;  ///< "unexplained {0} times the noise"
  std::string certainty;
  std::string response_gain;  ///< of a bench that is diagnosed by its speed, as the two below
  std::string response_time;
  std::string response_friction;
  std::string response_is;  ///< "{0}, before {1}"
  std::string runner_up;
  std::string runner_up_is;  ///< "{0}, {1} times worse"

  std::string path;  ///< heading: the paper's method
  std::string path_none;
  std::string yes;
  std::string no;
  std::string step;          ///< "{0} — {1} ({2}, limit {3})"
  std::string leads_to;      ///< " → {0}"
  std::string path_agrees;   ///< "It ends at {0}, as the verdict does."
  std::string path_alone;    ///< "It ends at {0}."
  std::string path_differs;  ///< "The path ends at {0}, but the verdict is {1}:" and why
  std::string why_unknown;   ///< a sentence of its own: {0} is the end of the path
  std::string why_settling;
  std::string why_close;  ///< "{0}"
  std::string why_window;

  std::string outside;  ///< questions of the path: "Is {0} outside its band?"
  std::string opposite;
  std::string same_way;

  std::string too_early;  ///< reasons of a verdict
  std::string too_late;
  std::string ends_too_soon;
  std::string worked_out;
  std::string no_single;
  std::string sensor_gain;  ///< "{0}": a channel; "{1}": by how much
  std::string sensor_high;
  std::string sensor_low;
  std::string warmed;  ///< "{0}": by how many percent
  std::string beside;  ///< "{0}", "{1}": components
  std::string two;

  std::string before_after;
  std::string parameter;
  std::string before;
  std::string after;
  std::string change;
  std::string model;
  std::string published;
  std::string changed_at;  ///< "{0} at {1} s"
  std::string change_at;   ///< "Change at {0} s"
  std::string no_model;    ///< "; no model: not nominal either: {0}"
  std::string means;

  std::string figures;
  std::string figure_signals;
  std::string figure_swa;
  std::string figure_sia;
  std::string figure_models;
  std::string no_figure;  ///< "{0}: {1}"

  std::string origin;
  std::string program;
  std::string checksum;  ///< "SHA-256 of the CSV"
  std::string address;
  std::string no_address;  ///< what to do so that reports have a link
};

const ReportWords& WordsOf(Language language);

/// The text with {0}, {1}.. replaced.
std::string Fill(std::string_view text, std::initializer_list<std::string_view> values);

}  // namespace faultlab::server

#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace faultlab::server {

enum class Language { kEnglish, kSerbian };

/// "en", "sr" (Latin script).
std::optional<Language> ParseLanguage(std::string_view name);

/// All texts of a report in one language. {0}, {1}.. are filled in.
struct ReportWords {
  const char* report;  ///< the kind of document, above its title
  const char* run;
  const char* made_by;
  const char* guest;
  const char* time;
  const char* rig;
  const char* uploaded;
  const char* bench;
  const char* description;  ///< "{0}, description {1}": bench's title and id
  const char* state;
  const char* state_finished;
  const char* state_stopped;
  const char* state_failed;
  const char* state_interrupted;
  const char* samples;  ///< "{0} samples, {1} apart: {2} s"
  const char* samples_name;
  const char* settings;
  const char* excitation;
  const char* replay_of;
  const char* calibration;
  const char* calibrated_on_run;  ///< "from this recording, {0} to {1} s"
  const char* calibrated_before;  ///< "of {0}": stored with the rig
  const char* calibration_none;
  const char* delta;
  const char* noise;
  const char* false_alarms;  ///< "{0} a day over all tests"
  const char* false_alarms_name;

  const char* faults;  ///< heading
  const char* faults_none;
  const char* faults_more;  ///< "and {0} more, in the JSON export"
  const char* at_time;      ///< columns
  const char* at_sample;
  const char* component;
  const char* value;
  const char* rig_says;
  const char* confirmed;
  const char* refused;
  const char* unconfirmed;
  const char* nominal;  ///< "nominal"

  const char* verdict;
  const char* verdict_fault;  ///< "Fault: {0}"
  const char* or_word;
  const char* verdict_unknown;
  const char* verdict_nominal;
  const char* verdict_not_excited;
  const char* verdict_none;
  const char* unsettled;
  const char* detected;
  const char* detected_at;     ///< "at {0} s by {1}"
  const char* began_at;        ///< ", began at about {0} s"
  const char* standard_error;  ///< "{0}, standard error {1}; nominal {2}"
  const char* bound;           ///< "{0}; nominal {1}"
  const char* group;
  const char* explains;  ///< "residual {0} times what noise alone leaves (1: explains all)"
  const char* certainty;
  const char* runner_up;
  const char* runner_up_is;  ///< "{0}: residual {1} times"

  const char* path;  ///< heading: the paper's method
  const char* path_none;
  const char* yes;
  const char* no;
  const char* step;          ///< "{0} — {1} ({2}, limit {3})"
  const char* leads_to;      ///< " → {0}"
  const char* path_agrees;   ///< "It ends at {0}, as the verdict does."
  const char* path_alone;    ///< "It ends at {0}."
  const char* path_differs;  ///< "It ends at {0}, the verdict is {1}."
  const char* why_unknown;
  const char* why_settling;
  const char* why_close;  ///< "{0}"
  const char* why_window;

  const char* before_after;
  const char* parameter;
  const char* before;
  const char* after;
  const char* change;
  const char* model;
  const char* model_for;  ///< "Model: prediction of the calibrated model for {0}"
  const char* means;

  const char* figures;
  const char* figure_signals;
  const char* figure_swa;
  const char* figure_sia;
  const char* figure_models;
  const char* no_figure;  ///< "{0}: {1}"

  const char* origin;
  const char* program;
  const char* checksum;  ///< "SHA-256 of the CSV"
  const char* address;
};

const ReportWords& WordsOf(Language language);

/// The text with {0}, {1}.. replaced.
std::string Fill(std::string_view text, std::initializer_list<std::string_view> values);

}  // namespace faultlab::server

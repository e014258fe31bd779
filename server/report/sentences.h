#pragma once

#include <string>

#include "server/report/report_words.h"

namespace faultlab::server {

/// What the diagnosis says in English, in the words of a report. It is known by its form, as on the
/// page (web/src/i18n/rig_words); what is not known here stays as it is.
std::string QuestionIn(const ReportWords& words, const std::string& question);
std::string ReasonIn(const ReportWords& words, const std::string& reason);

}  // namespace faultlab::server

#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/bench/bench.h"
#include "core/diagnosis/diagnosis.h"
#include "core/types/result.h"
#include "server/plots/figure.h"
#include "server/report/report_words.h"
#include "server/story/run_story.h"

namespace faultlab::server {

/// What a rig did with one change of a component.
struct ReportFault {
  enum class Said { kConfirmed, kRefused, kNothing };
  double t_s = 0.0;
  std::int64_t index = 0;
  core::Component component{};
  double value = 0.0;  ///< SI
  Said said = Said::kNothing;
};

/// Means of the estimates of one estimator.
struct ReportEstimates {
  std::string title;  ///< "SWA, K = 100"
  struct Row {
    std::string name;  ///< "b0d"
    std::optional<double> before;
    std::optional<double> after;
    std::optional<double> model;      ///< after, as the model of the bench predicts it
    std::optional<double> published;  ///< after, as it was published
  };
  std::vector<Row> rows;
};

/// One change, and the estimates before and after it.
struct ReportChange {
  std::optional<double> t_s;            ///< nothing: nothing has changed
  core::Component component{};          ///< none when only the time is known
  std::optional<double> before;         ///< its value until then, SI
  double value = 0.0;                   ///< SI
  std::vector<core::Component> others;  ///< that were not nominal then: there is no model
  std::vector<ReportEstimates> estimates;
};

/// Everything that a report says. Whoever fills it leaves out what its reader may not see.
/// Of a run that kept its speed.
struct ReportControl {
  std::string shape;     ///< "steps", "ramp", "prbs"
  double low_rpm = 0.0;  ///< behind the gear, as n
  double high_rpm = 0.0;
  double hold_s = 0.0;
  double from_s = 0.0;
  struct MadeUp {
    double t_s = 0.0;
    core::Component component{};
    double value = 0.0;
  };
  std::vector<MadeUp> made_up;
  struct Judged {
    double from_s = 0.0;
    double iae_rad = 0.0;
    double steady_error_rpm = 0.0;
  };
  std::optional<Judged> judged;  ///< nothing: the speed was never kept
  std::optional<Judged> alone;   ///< the same run without compensation; nothing: not known
};

struct RunReport {
  std::string id;
  std::string name;
  std::string made_by;   ///< empty: a guest
  std::string began_at;  ///< ISO 8601, UTC
  std::string ended_at;
  std::string state;                   ///< "finished", "stopped", "failed", "interrupted"
  std::string rig;                     ///< empty for an upload
  const core::Bench* bench = nullptr;  ///< never null
  std::int64_t samples = 0;
  double period_s = 0.0;
  std::string excitation;  ///< "prbs: low_v 2, high_v 3"; empty: not known
  std::optional<ReportControl> control{};
  std::string replay_of;  ///< id of the recording; empty: none
  std::vector<ReportFault> faults;
  bool sealed = false;  ///< what was switched, and what was found, is told later

  core::Diagnosis diagnosis;
  RunStory story;
  std::string calibration_refusal;    ///< why there is none
  std::vector<ReportChange> changes;  ///< the newest, in time order

  /// The figures by name, in this order. Made one after the other, each when it is drawn: those of
  /// a long run are large.
  std::vector<std::string> figures;
  std::function<core::Result<Figure>(const std::string&)> figure;

  std::string version;     ///< "0.1.0"
  std::string csv_sha256;  ///< 64 hex digits
  std::string address;     ///< of the run's page; empty: not known
};

/// The report as PDF, A4, one to three pages: facts, verdict, path, tables; then the figures, 300
/// dpi. The same report gives the same bytes. kUnavailable without a font.
/// Thread-safe; about half a second of CPU.
core::Result<std::string> ReportPdf(const RunReport& report, Language language);

}  // namespace faultlab::server

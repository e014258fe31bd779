#include <string>

#include "server/report/report_section.h"

namespace faultlab::server {
namespace {

class FactsSection : ReportSection {
 public:
  FactsSection(const RunReport& report, const ReportWords& words) : ReportSection(report, words) {}

  void Write(PdfDocument& paper) const {
    paper.Fact(words_.run, report_.id + ", " + State());
    paper.Fact(words_.made_by, report_.made_by.empty() ? words_.guest : report_.made_by);
    const std::string ended = Readable(report_.ended_at);
    paper.Fact(words_.time, Readable(report_.began_at) + (ended.empty() ? "" : " – " + ended));
    paper.Fact(words_.rig, report_.rig.empty() ? words_.uploaded : report_.rig);
    paper.Fact(words_.bench, Fill(words_.description, {report_.bench->title, report_.bench->id}));
    paper.Fact(words_.samples_name,
               Fill(words_.samples,
                    {std::to_string(report_.samples),
                     Digits(kMilli * report_.period_s, 6),
                     Digits(static_cast<double>(report_.samples) * report_.period_s, 6)}));
    paper.Fact(words_.excitation, report_.excitation);
    if (report_.control) Control(*report_.control, paper);
    paper.Fact(words_.replay_of, report_.replay_of);
    Calibration(paper);
  }

 private:
  std::string State() const {
    if (report_.state == "stopped") return words_.state_stopped;
    if (report_.state == "failed") return words_.state_failed;
    if (report_.state == "interrupted") return words_.state_interrupted;
    return words_.state_finished;
  }

  void Control(const ReportControl& control, PdfDocument& paper) const {
    const std::string& shape = control.shape == "ramp"   ? words_.control_ramp
                               : control.shape == "prbs" ? words_.control_prbs
                                                         : words_.control_steps;
    paper.Fact(words_.control,
               Fill(shape,
                    {Digits(control.low_rpm, 4),
                     Digits(control.high_rpm, 4),
                     Digits(control.hold_s, 6),
                     Digits(control.from_s, 6)}));
    std::string made_up;
    for (const ReportControl::MadeUp& each : control.made_up) {
      made_up += made_up.empty() ? "" : "; ";
      made_up += Fill(
          words_.control_since,
          {std::string(core::Name(each.component)) + " = " + ValueOf(each.component, each.value),
           Fixed(each.t_s, 2)});
    }
    paper.Fact(words_.control_made_up, made_up);
    const auto judged = [this](const ReportControl::Judged& of) {
      return Fill(words_.control_judged,
                  {Digits(of.iae_rad, 3), Digits(of.steady_error_rpm, 3), Fixed(of.from_s, 2)});
    };
    paper.Fact(words_.control_deviation,
               control.judged ? judged(*control.judged) : words_.control_never);
    if (control.alone) paper.Fact(words_.control_alone, judged(*control.alone));
  }

  void Calibration(PdfDocument& paper) const {
    if (!report_.diagnosis.calibration) {
      paper.Fact(
          words_.calibration,
          std::string(words_.calibration_none) +
              (report_.calibration_refusal.empty() ? "" : ": " + report_.calibration_refusal));
      return;
    }
    const core::Calibration& found = *report_.diagnosis.calibration;
    paper.Fact(words_.calibration,
               found.dated.empty()
                   ? Fill(words_.calibrated_on_run, {Fixed(found.from_s, 2), Fixed(found.to_s, 2)})
                   : Fill(words_.calibrated_before, {Readable(found.dated)}));
    paper.Fact(words_.delta, Digits(kMilli * found.delta_s, 4) + " ms");
    std::string noise;
    const auto add = [&noise](const std::string& channel) {
      noise += (noise.empty() ? "" : ", ") + channel;
    };
    if (found.used_um) add("um " + Digits(kMilli * found.um_noise_v, 3) + " mV");
    if (found.used_ia) add("ia " + Digits(kMilli * found.ia_noise_a, 3) + " mA");
    if (found.used_n) add("n " + Digits(found.n_noise_rpm, 3) + " rpm");
    paper.Fact(words_.noise, noise);
    paper.Fact(words_.false_alarms_name,
               Fill(words_.false_alarms, {Digits(found.thresholds.false_alarms_per_day, 3)}));
  }
};

}  // namespace

void WriteFacts(const RunReport& report, const ReportWords& words, PdfDocument& paper) {
  FactsSection(report, words).Write(paper);
}

}  // namespace faultlab::server

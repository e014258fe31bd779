#include "server/report/report.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <memory>

#include "server/plots/render.h"
#include "server/plots/value_text.h"
#include "server/report/paper.h"
#include "server/report/path_outcome.h"
#include "server/report/sentences.h"

namespace faultlab::server {
namespace {

constexpr int kPagesMax = 3;
constexpr std::size_t kFaultsShown = 10;
constexpr std::size_t kStepsShown = 6;
constexpr std::size_t kEpisodesShown = 6;
constexpr double kMilli = 1e3;

std::string Signed(std::string text) {
  return text.starts_with('-') ? "\u2212" + text.substr(1) : text;
}

/// Without "-0.0".
std::string Fixed(double value, int decimals) {
  if (!std::isfinite(value)) return "–";
  std::array<char, 400> text;
  const auto end = std::to_chars(
      text.data(), text.data() + text.size(), value, std::chars_format::fixed, decimals);
  const std::string number(text.data(), end.ptr);
  return number.find_first_not_of("-0.") == std::string::npos ? Signed(number.substr(value < 0.0))
                                                              : Signed(number);
}

/// "10^{−6}" -> "10⁻⁶": the page's text has no other markup.
std::string Raised(const std::string& text) {
  static const std::array<const char*, 10> kRaised = {
      "⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  const std::size_t at = text.find("^{");
  const std::size_t end = text.find('}', at);
  if (at == std::string::npos || end == std::string::npos) return text;
  std::string out = text.substr(0, at);
  std::string power = text.substr(at + 2, end - at - 2);
  const std::string minus = "\u2212";
  if (power.starts_with(minus)) {
    out += "⁻";
    power.erase(0, minus.size());
  }
  for (const char c : power) {
    if (c >= '0' && c <= '9') out += kRaised[static_cast<std::size_t>(c - '0')];
  }
  return out + text.substr(end + 1);
}

/// "1.86·10⁻⁵" for "1.86e-05"; a large number has no power: "1857".
std::string Digits(double value, int digits) {
  if (!std::isfinite(value)) return "–";
  std::array<char, 40> text;
  const auto end = std::to_chars(
      text.data(), text.data() + text.size(), value, std::chars_format::general, digits);
  const std::string_view number(text.data(), static_cast<std::size_t>(end.ptr - text.data()));
  const std::size_t power = number.find('e');
  if (power == std::string_view::npos) return Signed(std::string(number));
  if (number[power + 1] != '-') return Fixed(value, 0);
  const std::string_view digits_of = number.substr(number.find_first_not_of('0', power + 2));
  return Signed(
      Raised(std::string(number.substr(0, power)) + "·10^{\u2212" + std::string(digits_of) + "}"));
}

/// With at least so many digits, and never fewer than stand before the point: as the page does.
std::string Factor(double value, int digits) {
  if (!std::isfinite(value) || value <= 0.0) return "–";
  return Fixed(value, std::max(0, digits - 1 - static_cast<int>(std::floor(std::log10(value)))));
}

/// For tables and the path, as the page writes it: four digits, "0.07870".
std::string Number(std::optional<double> value) {
  if (!value || !std::isfinite(*value)) return "–";
  constexpr int kDigits = 4;
  constexpr int kDecimalsMax = 6;
  constexpr double kSmall = 1e-4;
  const double size = std::abs(*value);
  if (size == 0.0) return "0";
  if (size < kSmall) return Digits(*value, kDigits);
  const int power = static_cast<int>(std::floor(std::log10(size)));
  return Fixed(*value, std::clamp(kDigits - 1 - power, 0, kDecimalsMax));
}

std::string ValueOf(core::Component component, double value, int digits = 4) {
  return std::isfinite(value) ? Raised(ValueText(value, core::Unit(component), digits)) : "–";
}

std::string Joined(const std::vector<std::string>& names, std::string_view word) {
  std::string out;
  for (const std::string& name : names) {
    if (!out.empty()) out.append(" ").append(word).append(" ");
    out += name;
  }
  return out;
}

/// "2026-11-21T01:02:03.456Z" -> "2026-11-21T01:02:03Z", which cairo reads.
std::string ToTheSecond(const std::string& iso) {
  return iso.substr(0, iso.find('.')) + (iso.find('.') == std::string::npos ? "" : "Z");
}

/// "2026-11-21T01:02:03.456Z" -> "2026-11-21 01:02:03 UTC"
std::string Readable(const std::string& iso) {
  constexpr std::size_t kToTheSecond = 19;
  if (iso.size() < kToTheSecond) return iso;
  std::string out = iso.substr(0, kToTheSecond) + " UTC";
  out[10] = ' ';
  return out;
}

/// Writes one report onto a paper.
class Writer {
 public:
  Writer(const RunReport& report, Language language) : report_(report), words_(WordsOf(language)) {}

  // Numbers as the report's language writes them.
  std::string Digits(double value, int digits) const {
    return Local(server::Digits(value, digits));
  }
  std::string Fixed(double value, int decimals) const {
    return Local(server::Fixed(value, decimals));
  }
  std::string Number(std::optional<double> value) const { return Local(server::Number(value)); }
  std::string Factor(double value, int digits) const {
    return Local(server::Factor(value, digits));
  }
  std::string ValueOf(core::Component component, double value, int digits = 4) const {
    return Local(server::ValueOf(component, value, digits));
  }

  Paper::About About(int pages_total) const {
    return {.title = Title(),
            .author = report_.made_by,
            .creator = "faultlab " + report_.version,
            .made_at = ToTheSecond(report_.ended_at.empty() ? report_.began_at : report_.ended_at),
            .footer = std::string(words_.run) + " " + report_.id,
            .pages_total = pages_total};
  }

  void Text(Paper& paper) const {
    if (!report_.address.empty()) {
      if (const auto code = MakeQrCode(report_.address)) paper.Code(*code, report_.address);
    }
    paper.Paragraph(words_.report, Paper::Tone::kQuiet);
    paper.Title(Title());
    Facts(paper);
    Verdict(paper);
    Path(paper);
    Faults(paper);
    Estimates(paper);
    Origin(paper);
  }

  /// A figure that could not be drawn is a sentence.
  void Figures(Paper& paper,
               const std::vector<core::Result<Pixels>>& pictures,
               double height_mm) const {
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      const std::string caption = Caption(report_.figures[i]);
      if (pictures[i].ok()) {
        paper.Picture(pictures[i].value(), height_mm, caption);
      } else {
        paper.Paragraph(Fill(words_.no_figure, {caption, pictures[i].error().message}));
      }
    }
  }

 private:
  /// Of a run without a name: its rig and when it was.
  std::string Title() const {
    if (!report_.name.empty()) return report_.name;
    return (report_.rig.empty() ? words_.uploaded : report_.rig) + ", " +
           Readable(report_.began_at);
  }

  std::string Caption(const std::string& name) const {
    if (name == "signals") return words_.figure_signals;
    if (name == "swa") return words_.figure_swa;
    if (name == "sia") return words_.figure_sia;
    return words_.figure_models;
  }

  std::string State() const {
    if (report_.state == "stopped") return words_.state_stopped;
    if (report_.state == "failed") return words_.state_failed;
    if (report_.state == "interrupted") return words_.state_interrupted;
    return words_.state_finished;
  }

  void Facts(Paper& paper) const {
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

  void Control(const ReportControl& control, Paper& paper) const {
    const std::string& shape = control.shape == "ramp"   ? words_.control_ramp
                               : control.shape == "prbs" ? words_.control_prbs
                                                         : words_.control_steps;
    paper.Fact(words_.control,
               Fill(shape,
                    {Digits(control.low_rad_s, 6),
                     Digits(control.high_rad_s, 6),
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
    paper.Fact(words_.control_deviation,
               control.judged ? Fill(words_.control_judged,
                                     {Digits(control.judged->iae_rad, 3),
                                      Digits(control.judged->steady_error_rad_s, 3),
                                      Fixed(control.judged->from_s, 2)})
                              : words_.control_never);
  }

  void Calibration(Paper& paper) const {
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

  std::string VerdictText() const { return VerdictText(report_.diagnosis.verdict); }

  std::string VerdictText(const core::Verdict& verdict) const {
    switch (verdict.kind) {
      case core::VerdictKind::kFault:
        return Fill(words_.verdict_fault,
                    {Joined(NamedBy(verdict), words_.or_word) + Arrow(verdict)});
      case core::VerdictKind::kUnknownFault:
        return verdict.sensor ? Fill(words_.verdict_sensor, {verdict.sensor->channel})
                              : words_.verdict_unknown;
      case core::VerdictKind::kNominal:
        return words_.verdict_nominal;
      case core::VerdictKind::kNotExcited:
        return words_.verdict_not_excited;
      case core::VerdictKind::kCalibrating:
        break;
    }
    return words_.verdict_none;
  }

  /// Of one component: whether its value is larger or smaller than the nominal one.
  static const char* Arrow(const core::Verdict& verdict) {
    if (verdict.candidates.empty() || NamedBy(verdict).size() != 1) return "";
    const core::Candidate& best = verdict.candidates.front();
    return best.value >= best.component.info().nominal ? " ↑" : " ↓";
  }

  std::string Sized(const core::Candidate& candidate) const {
    const std::string value = ValueOf(candidate.component, candidate.value);
    const std::string nominal = ValueOf(candidate.component, candidate.component.info().nominal);
    if (candidate.bound != 0) {
      return Fill(words_.bound, {std::string(1, candidate.bound) + " " + value, nominal});
    }
    return Fill(words_.standard_error, {WithError(candidate), nominal});
  }

  std::string WithError(const core::Candidate& candidate) const {
    return Local(Raised(
        ValueWithErrorText(candidate.value, candidate.sigma, core::Unit(candidate.component), 4)));
  }

  /// "R9 = 33.0 ± 0.2 kΩ", or "C8 > 5 mF" where only a bound is known.
  std::string Stated(const core::Candidate& candidate) const {
    const std::string name(core::Name(candidate.component));
    if (candidate.bound == 0) return name + " = " + WithError(candidate);
    return name + " " + candidate.bound + " " + ValueOf(candidate.component, candidate.value);
  }

  /// "the residual test" of "residual", as the page calls it.
  std::string Detector(const std::string& name) const {
    if (name == "residual") return words_.detector_residual;
    if (name == "cusum") return words_.detector_cusum;
    const std::string_view glr = "glr_";
    if (name.starts_with(glr)) return Fill(words_.detector_glr, {name.substr(glr.size())});
    return name;
  }

  std::string DetectedText(const core::Detection& one) const {
    std::string text =
        Fill(words_.detected_at, {Fixed(one.detected_at_s, 2), Detector(one.detector)});
    if (one.onset_s) text += Fill(words_.began_at, {Fixed(*one.onset_s, 2)});
    return text;
  }

  /// What was found before the verdict, newest last: the rig may be nominal again.
  void Earlier(Paper& paper) const {
    const std::vector<core::FaultEpisode>& all = report_.diagnosis.episodes;
    const std::size_t from = all.size() > kEpisodesShown ? all.size() - kEpisodesShown : 0;
    for (std::size_t i = from; i < all.size(); ++i) {
      const core::FaultEpisode& episode = all[i];
      if (!episode.ended_at_s || !episode.verdict.detected_at_s) continue;
      std::string said = VerdictText(episode.verdict);
      if (episode.verdict.group.size() == 1 && !episode.verdict.candidates.empty()) {
        said = Fill(words_.verdict_fault, {Stated(episode.verdict.candidates.front())});
      }
      std::string times;
      for (const core::Detection& one : core::DetectionsOf(episode.verdict)) {
        times += (times.empty() ? "" : ", ") + Fixed(one.detected_at_s, 2);
      }
      paper.Fact(words_.earlier,
                 Fill(words_.earlier_is, {said, times, Fixed(*episode.ended_at_s, 2)}));
    }
  }

  /// How the motor answers, where the speed alone tells of it.
  void Response(Paper& paper, const core::ResponseChange& response) const {
    const auto fact = [&](const std::string& name,
                          const core::Measured core::SpeedResponse::*number,
                          double factor,
                          std::string_view unit) {
      const auto text = [&](const core::SpeedResponse& one) {
        const core::Measured& measured = one.*number;
        return Local(
            Raised(ValueWithErrorText(factor * measured.value, factor * measured.sigma, unit, 4)));
      };
      paper.Fact(name, Fill(words_.response_is, {text(response.after), text(response.before)}));
    };
    fact(words_.response_gain, &core::SpeedResponse::gain, 1.0, "rpm/V");
    fact(words_.response_time, &core::SpeedResponse::time_constant, kMilli, "ms");
    fact(words_.response_friction, &core::SpeedResponse::friction, 1.0, "rpm");
  }

  void Verdict(Paper& paper) const {
    const core::Verdict& verdict = report_.diagnosis.verdict;
    paper.Heading(words_.verdict);
    paper.Paragraph(VerdictText(), Paper::Tone::kStrong);
    if (verdict.kind == core::VerdictKind::kFault) {
      const std::vector<std::string> named = NamedBy(verdict);
      const auto name_of = [](const core::Candidate& one) {
        return std::string(core::Name(one.component));
      };
      for (const std::string& name : named) {
        const auto found = std::ranges::find(verdict.candidates, name, name_of);
        if (found != verdict.candidates.end()) paper.Fact(name, Sized(*found));
      }
      const auto runner_up = std::ranges::find_if(verdict.candidates, [&](const auto& one) {
        return std::ranges::find(named, name_of(one)) == named.end();
      });
      if (named.size() > 1) paper.Paragraph(words_.group);
      if (!verdict.candidates.empty()) {
        paper.Fact(words_.certainty,
                   Fill(words_.explains, {Digits(verdict.candidates.front().score, 3)}));
      }
      if (verdict.response) Response(paper, *verdict.response);
      if (runner_up != verdict.candidates.end()) {
        paper.Fact(words_.runner_up,
                   Fill(words_.runner_up_is,
                        {Stated(*runner_up),
                         Factor(runner_up->score / verdict.candidates.front().score, 2)}));
      }
    }
    std::string label = words_.detected;
    for (const core::Detection& one : core::DetectionsOf(verdict)) {
      paper.Fact(label, DetectedText(one));
      label = words_.detected_again;
    }
    Earlier(paper);
    const bool usual = verdict.reason.find("warms up") == std::string::npos;
    const bool explained = verdict.kind == core::VerdictKind::kFault ||
                           (verdict.kind == core::VerdictKind::kNominal && usual);
    if (!explained && !verdict.reason.empty()) paper.Paragraph(ReasonIn(words_, verdict.reason));
    const bool concluded = verdict.kind == core::VerdictKind::kFault ||
                           verdict.kind == core::VerdictKind::kUnknownFault;
    if (concluded && !verdict.settled) paper.Paragraph(words_.unsettled);
  }

  void Path(Paper& paper) const {
    const core::Verdict& verdict = report_.diagnosis.verdict;
    if (verdict.path.empty() && report_.bench->published.source.empty()) return;
    paper.Heading(words_.path);
    if (verdict.path.empty()) {
      paper.Paragraph(words_.path_none);
      return;
    }
    for (std::size_t i = 0; i < std::min(verdict.path.size(), kStepsShown); ++i) {
      const core::PathStep& step = verdict.path[i];
      std::string text = std::to_string(i + 1) + ". " +
                         Fill(words_.step,
                              {QuestionIn(words_, step.question),
                               step.answer ? words_.yes : words_.no,
                               Number(step.value),
                               Number(step.threshold)});
      if (!step.leads_to.empty()) text += Fill(words_.leads_to, {NamesIn(words_, step.leads_to)});
      paper.Paragraph(text);
    }
    Outcome(paper);
  }

  void Outcome(Paper& paper) const {
    const core::Verdict& verdict = report_.diagnosis.verdict;
    std::string end = Joined(PathEnd(verdict.path, *report_.bench), words_.or_word);
    const PathOutcome outcome = ComparePath(verdict, *report_.bench);
    if (outcome == PathOutcome::kNothing) {
      if (!end.empty()) paper.Paragraph(Fill(words_.path_alone, {end}));
      return;
    }
    if (end.empty()) end = "–";
    if (outcome == PathOutcome::kAgrees) {
      paper.Paragraph(Fill(words_.path_agrees, {end}));
      return;
    }
    if (outcome == PathOutcome::kUnknown) {
      paper.Paragraph(Fill(words_.why_unknown, {end}), Paper::Tone::kStrong);
      return;
    }
    std::string why = words_.why_window;
    if (outcome == PathOutcome::kSettling) why = words_.why_settling;
    if (outcome == PathOutcome::kClose) {
      const auto step = std::ranges::find_if(verdict.path, IsClose);
      why = Fill(words_.why_close, {QuestionIn(words_, step->question)});
    }
    const std::string said = Joined(NamedBy(verdict), words_.or_word);
    paper.Paragraph(Fill(words_.path_differs, {end, said}) + " " + why, Paper::Tone::kStrong);
  }

  void Faults(Paper& paper) const {
    if (report_.rig.empty()) return;
    paper.Heading(words_.faults);
    if (report_.faults.empty()) {
      paper.Paragraph(words_.faults_none);
      return;
    }
    const std::array<Paper::Column, 5> columns = {{{words_.at_time, 22, true},
                                                   {words_.at_sample, 22, true},
                                                   {words_.component, 32, false},
                                                   {words_.value, 50, false},
                                                   {words_.rig_says, 48, false}}};
    std::vector<std::vector<std::string>> rows;
    for (const ReportFault& fault : report_.faults) {
      if (rows.size() == kFaultsShown) break;
      const bool nominal = fault.value == fault.component.info().nominal;
      rows.push_back({Fixed(fault.t_s, 2),
                      std::to_string(fault.index),
                      std::string(core::Name(fault.component)),
                      ValueOf(fault.component, fault.value) +
                          (nominal ? std::string(" (") + words_.nominal + ")" : ""),
                      fault.said == ReportFault::Said::kConfirmed ? words_.confirmed
                      : fault.said == ReportFault::Said::kRefused ? words_.refused
                                                                  : words_.unconfirmed});
    }
    paper.Table(columns, rows);
    if (report_.faults.size() > kFaultsShown) {
      paper.Paragraph(
          Fill(words_.faults_more, {std::to_string(report_.faults.size() - kFaultsShown)}));
    }
  }

  void Estimates(Paper& paper) const {
    if (report_.changes.empty()) return;
    paper.Heading(words_.before_after);
    for (const ReportChange& change : report_.changes) Estimates(paper, change);
    paper.Paragraph(words_.means, Paper::Tone::kQuiet);
  }

  void Estimates(Paper& paper, const ReportChange& change) const {
    const std::string about = About(change);
    if (!about.empty()) paper.Paragraph(about);
    const bool published = !report_.bench->published.source.empty();
    std::vector<Paper::Column> columns = {{words_.parameter, 20, false},
                                          {"", 38, false},
                                          {words_.before, 23, true},
                                          {words_.after, 23, true},
                                          {words_.change, 23, true},
                                          {words_.model, 23, true}};
    if (published) columns.push_back({words_.published, 24, true});
    std::vector<std::vector<std::string>> rows;
    for (const ReportEstimates& one : change.estimates) {
      for (const ReportEstimates::Row& row : one.rows) {
        const bool both = row.before && row.after && *row.before != 0.0;
        rows.push_back({row.name,
                        one.title,
                        Number(row.before),
                        Number(row.after),
                        both ? Change(*row.before, *row.after) : "–",
                        Number(row.model)});
        if (published) rows.back().push_back(Number(row.published));
      }
    }
    paper.Table(columns, rows);
  }

  /// "R12: 11.2 kΩ → 5.6 kΩ at 8.00 s"
  std::string About(const ReportChange& change) const {
    if (!change.t_s) return {};
    if (!change.component.exists()) return Fill(words_.change_at, {Fixed(*change.t_s, 2)});
    std::string text = std::string(core::Name(change.component)) + ": ";
    if (change.before) text += ValueOf(change.component, *change.before) + " → ";
    text = Fill(words_.changed_at,
                {text + ValueOf(change.component, change.value), Fixed(*change.t_s, 2)});
    std::string others;
    for (const core::Component other : change.others) {
      others.append(others.empty() ? "" : ", ").append(core::Name(other));
    }
    if (!others.empty()) text += Fill(words_.no_model, {others});
    return text;
  }

  /// Of the magnitude, as the page has it: −1.1 -> −0.66 is −40 %.
  std::string Change(double before, double after) const {
    constexpr double kPercent = 100.0;
    const double change = kPercent * (after / before - 1.0);
    return (change > 0.0 ? "+" : "") + Fixed(change, 0);
  }

  void Origin(Paper& paper) const {
    paper.Heading(words_.origin);
    paper.Fact(words_.program, "faultlab " + report_.version);
    paper.Fact(words_.checksum, report_.csv_sha256);
    paper.Fact(words_.address, report_.address);
    if (report_.address.empty()) paper.Paragraph(words_.no_address, Paper::Tone::kQuiet);
  }

  std::string Local(std::string number) const {
    std::replace(number.begin(), number.end(), '.', words_.decimal_sign);
    return number;
  }

  const RunReport& report_;
  const ReportWords& words_;
};

/// The largest height at which `count` pictures fit on the pages that are left.
double PictureHeight(std::size_t count, int page, double left_mm) {
  constexpr double kHighest = 120.0;
  constexpr double kLowest = 60.0;
  constexpr double kStep = 2.0;
  for (double height = kHighest; height > kLowest; height -= kStep) {
    const double each = Paper::PictureMm(height);
    const auto fits = [&](double room) {
      return static_cast<std::size_t>(std::max(0.0, room / each));
    };
    std::size_t room = fits(left_mm);
    for (int next = page + 1; next <= kPagesMax; ++next) room += fits(Paper::kHeightMm);
    if (room >= count) return height;
  }
  return kLowest;
}

/// For a draft, which needs their number alone.
std::vector<core::Result<Pixels>> WithoutPixels(const std::vector<core::Result<Pixels>>& pictures) {
  std::vector<core::Result<Pixels>> out;
  for (const auto& picture : pictures) {
    out.push_back(picture ? core::Result<Pixels>(Pixels{}) : picture.error());
  }
  return out;
}

/// A picture under a caption needs no heading and no footer of its own.
Figure Bare(Figure figure) {
  figure.title.clear();
  figure.subtitle.clear();
  figure.footer.clear();
  return figure;
}

}  // namespace

core::Result<std::string> ReportPdf(const RunReport& report, Language language) {
  const Writer writer(report, language);
  double height_mm = 0.0;
  {
    auto draft = Paper::Open(writer.About(0));
    if (!draft) return draft.error();
    writer.Text(*draft.value());
    height_mm =
        PictureHeight(report.figures.size(), draft.value()->page(), draft.value()->left_mm());
  }
  std::vector<core::Result<Pixels>> pictures;
  for (const std::string& name : report.figures) {
    auto figure = report.figure(name);
    pictures.push_back(
        figure ? RenderForPrint(Bare(std::move(figure).value()), Paper::kWidthMm, height_mm)
               : figure.error());
  }
  int pages = 0;
  {
    auto draft = Paper::Open(writer.About(0));
    if (!draft) return draft.error();
    writer.Text(*draft.value());
    writer.Figures(*draft.value(), WithoutPixels(pictures), height_mm);
    pages = draft.value()->page();
  }
  auto paper = Paper::Open(writer.About(pages));
  if (!paper) return paper.error();
  writer.Text(*paper.value());
  writer.Figures(*paper.value(), pictures, height_mm);
  return paper.value()->Finish();
}

}  // namespace faultlab::server

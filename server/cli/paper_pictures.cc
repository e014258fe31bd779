#include "server/cli/paper_pictures.h"

#include <filesystem>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "core/paper/reproduction/reproduction.h"
#include "server/cli/console.h"
#include "server/csv/file_io.h"
#include "server/plots/record_figure.h"
#include "server/plots/render.h"
#include "server/plots/value_text.h"

namespace faultlab::server {
namespace {

using core::Result;
using core::Status;
using core::TableFault;

constexpr double kFaultSeconds = 10.0;  // the middle of the paper's records

std::string FaultLabel(const TableFault& fault) {
  return ComponentLabel(fault.component) + " = " +
         ValueText(fault.value, core::Unit(fault.component));
}

class Painter {
 public:
  Painter(const core::Bench& bench, std::string folder, std::uint64_t seed)
      : bench_(bench), folder_(std::move(folder)), seed_(seed) {}

  /// A figure of one record, by name.
  Status Draw(int number, std::string_view name, const std::optional<TableFault>& fault) {
    const std::vector<core::Sample> samples = core::PaperRecord(bench_, fault, seed_);
    FigureContext context = Context(number);
    context.name = "Figure " + std::to_string(number) + " of the paper, simulated";
    if (fault) {
      context.faults = {{fault->component, fault->value, kFaultSeconds}};
    }
    core::DiagnosisOptions options = core::OptionsOf(bench_);
    options.values = core::ValuePrior::kTable2;
    Result<Figure> figure = MakeFigure(name, samples, options, std::move(context));
    return figure ? Save(number, figure.value()) : Status(figure.error());
  }

  /// Um of several faults, one panel for each group.
  Status DrawOverlay(int number,
                     const std::vector<std::pair<std::string, std::vector<TableFault>>>& groups) {
    std::vector<OverlayPanel> panels;
    for (const auto& [title, faults] : groups) {
      OverlayPanel panel;
      panel.title = title;
      for (const TableFault& fault : faults) {
        OverlayTrace trace;
        trace.name = FaultLabel(fault);
        for (const core::Sample& sample : core::PaperRecord(bench_, fault, seed_)) {
          trace.t_s.push_back(sample.t_s);
          trace.um_v.push_back(sample.um_v);
        }
        panel.traces.push_back(std::move(trace));
      }
      panels.push_back(std::move(panel));
    }
    FigureContext context = Context(number);
    context.name =
        "Figure " + std::to_string(number) + " of the paper, simulated; the fault acts at 10 s";
    return Save(number, MakeOverlayFigure(panels, context));
  }

 private:
  FigureContext Context(int number) const {
    FigureContext context;
    context.footer = "faultlab " + std::string(Version()) + ", reproduction of Figure " +
                     std::to_string(number) + ", seed " + std::to_string(seed_);
    return context;
  }

  Status Save(int number, const Figure& figure) {
    TRY(const auto png, RenderPng(figure));
    const std::filesystem::path path =
        std::filesystem::path(folder_) / ("figure_" + std::to_string(number) + ".png");
    return WriteFile(path.string(), png);
  }

  const core::Bench& bench_;
  std::string folder_;
  std::uint64_t seed_;
};

}  // namespace

Status DrawPaperPictures(const core::Bench& bench, const std::string& folder, std::uint64_t seed) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    return core::Error{core::ErrorCode::kUnavailable,
                       "cannot make the folder " + folder + ": " + error.message(),
                       "plots"};
  }
  Painter painter(bench, folder, seed);
  const auto of = [&](const char* symbol, double value) {
    return TableFault{bench.Find(symbol).value(), value};
  };
  const std::vector<std::function<Status()>> pictures = {
      [&] { return painter.Draw(14, "signals", std::nullopt); },
      [&] {
        return painter.DrawOverlay(
            15,
            {{"(a) R_{1}", {of("R1", 10), of("R1", 56), of("R1", 100)}},
             {"(b) R_{9}", {of("R9", 33e3), of("R9", 56e3), of("R9", 100e3)}},
             {"(c) C_{8}", {of("C8", 1e-6), of("C8", 10e-6), of("C8", 47e-6)}},
             {"(d) R_{12}", {of("R12", 5.6e3), of("R12", 3.3e3), of("R12", 2e3)}}});
      },
      [&] {
        return painter.DrawOverlay(16,
                                   {{"(a) R_{a}", {of("Ra", 0.741)}},
                                    {"(b) R_{a}", {of("Ra", 74.1)}},
                                    {"(c) B", {of("B", 1.8e-4), of("B", 1.8e-5)}},
                                    {"(d) J", {of("J", 1.43e-8), of("J", 1.43e-4)}}});
      },
      [&] { return painter.Draw(17, "swa", of("R1", 10)); },
      [&] { return painter.Draw(18, "swa", of("B", 1.8e-5)); },
      [&] { return painter.Draw(19, "sia", of("C8", 10e-6)); },
      [&] { return painter.Draw(20, "sia", of("Ra", 74.1)); },
      [&] { return painter.Draw(23, "models", of("R1", 100)); }};
  for (const std::function<Status()>& draw : pictures) {
    if (Status drawn = draw(); !drawn) {
      return drawn;
    }
  }
  return core::Done{};
}

}  // namespace faultlab::server

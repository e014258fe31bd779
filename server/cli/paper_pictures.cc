#include "server/cli/paper_pictures.h"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <utility>
#include <vector>

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

std::string ModelLabel(const std::string& name) {
  constexpr std::string_view kFriction = "mc_";
  if (!name.starts_with(kFriction)) return name == "swa" ? "SWA" : "SIA";
  const std::string mnm = name.substr(kFriction.size(), name.find("mNm") - kFriction.size());
  return "M_{c} " + mnm + " mNm";
}

class Maker {
 public:
  Maker(const core::Bench& bench, std::uint64_t seed) : bench_(bench), seed_(seed) {}

  /// A figure of one record, by name.
  Result<PaperFigure> OfRecord(int number,
                               std::string_view name,
                               const std::optional<TableFault>& fault) const {
    const std::vector<core::Sample> samples = core::PaperRecord(bench_, fault, seed_);
    core::DiagnosisOptions options = core::OptionsOf(bench_);
    options.values = core::ValuePrior::kTable2;
    TRY(auto figure, MakeFigure(name, samples, options, Context(number, fault)));
    return PaperFigure{number, std::move(figure)};
  }

  /// Um of several faults, one panel for each group.
  PaperFigure Overlay(
      int number,
      const std::vector<std::pair<std::string, std::vector<TableFault>>>& groups) const {
    std::vector<OverlayPanel> panels;
    for (const auto& [title, faults] : groups) {
      OverlayPanel panel;
      panel.title = title;
      for (const TableFault& fault : faults) {
        OverlayTrace trace;
        trace.name = FaultLabel(fault);
        for (const core::Sample& sample : core::PaperRecord(bench_, fault, seed_)) {
          trace.t_s.push_back(sample.t_s);
          trace.y.push_back(sample.um_v);
        }
        panel.traces.push_back(std::move(trace));
      }
      panels.push_back(std::move(panel));
    }
    FigureContext context = Context(number, std::nullopt);
    context.name += "; the fault acts at 10 s";
    return {number, MakeOverlayFigure(panels, context)};
  }

  /// The models of a row of Tables 13-20 with the fits that stand there.
  PaperFigure Models(int number, const TableFault& fault, const core::PaperTable& table) const {
    const core::PaperComparison compared = core::ComparePaperModels(bench_, fault, seed_);
    ModelComparison comparison;
    for (const core::Sample& sample : compared.stretch) {
      comparison.t_s.push_back(sample.t_s);
      comparison.y.push_back(sample.um_v);
    }
    for (const core::ComparedFit& model : compared.models) {
      const auto row = std::ranges::find_if(table.rows, [&](const core::TableRow& each) {
        return each.name == model.name && each.fault && each.fault->component == fault.component &&
               each.fault->value == fault.value;
      });
      comparison.models.push_back(
          {model.name, ModelLabel(model.name), row->ours, model.fit.simulated});
    }
    FigureContext context = Context(number, fault);
    context.footer += ", fits of Table " + std::to_string(table.table);
    return {number, MakeModelsFigure(comparison, context)};
  }

 private:
  FigureContext Context(int number, const std::optional<TableFault>& fault) const {
    FigureContext context;
    context.name = "Figure " + std::to_string(number) + " of the paper, simulated";
    context.footer = "faultlab " + std::string(Version()) + ", reproduction of Figure " +
                     std::to_string(number) + ", seed " + std::to_string(seed_);
    if (fault) context.faults = {{fault->component, fault->value, kFaultSeconds}};
    return context;
  }

  const core::Bench& bench_;
  std::uint64_t seed_;
};

}  // namespace

Result<std::vector<PaperFigure>> MakePaperFigures(const core::Bench& bench,
                                                  std::uint64_t seed,
                                                  const core::Reproduction& reproduction) {
  const Maker make(bench, seed);
  const auto of = [&](const char* symbol, double value) {
    return TableFault{bench.Find(symbol).value(), value};
  };
  const TableFault r1_100 = of("R1", 100);
  std::vector<PaperFigure> figures;
  TRY(figures.emplace_back(), make.OfRecord(4, "friction", std::nullopt));
  TRY(figures.emplace_back(), make.OfRecord(6, "steps", of("C8", 10e-6)));
  TRY(figures.emplace_back(), make.OfRecord(14, "signals", std::nullopt));
  figures.push_back(
      make.Overlay(15,
                   {{"(a) R_{1}", {of("R1", 10), of("R1", 56), r1_100}},
                    {"(b) R_{9}", {of("R9", 33e3), of("R9", 56e3), of("R9", 100e3)}},
                    {"(c) C_{8}", {of("C8", 1e-6), of("C8", 10e-6), of("C8", 47e-6)}},
                    {"(d) R_{12}", {of("R12", 5.6e3), of("R12", 3.3e3), of("R12", 2e3)}}}));
  figures.push_back(make.Overlay(16,
                                 {{"(a) R_{a}", {of("Ra", 0.741)}},
                                  {"(b) R_{a}", {of("Ra", 74.1)}},
                                  {"(c) B", {of("B", 1.8e-4), of("B", 1.8e-5)}},
                                  {"(d) J", {of("J", 1.43e-8), of("J", 1.43e-4)}}}));
  TRY(figures.emplace_back(), make.OfRecord(17, "swa", of("R1", 10)));
  TRY(figures.emplace_back(), make.OfRecord(18, "swa", of("B", 1.8e-5)));
  TRY(figures.emplace_back(), make.OfRecord(19, "sia", of("C8", 10e-6)));
  TRY(figures.emplace_back(), make.OfRecord(20, "sia", of("Ra", 74.1)));
  TRY(figures.emplace_back(), make.OfRecord(21, "decisions", of("C8", 10e-6)));
  const auto table = std::ranges::find(reproduction.tables, 14, &core::PaperTable::table);
  figures.push_back(make.Models(23, r1_100, *table));
  return figures;
}

Status DrawPaperFigures(const std::vector<PaperFigure>& figures, const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    return core::Error{core::ErrorCode::kUnavailable,
                       "cannot make the folder " + folder + ": " + error.message(),
                       "plots"};
  }
  for (const PaperFigure& each : figures) {
    TRY(const auto png, RenderPng(each.figure));
    const std::filesystem::path path =
        std::filesystem::path(folder) / ("figure_" + std::to_string(each.number) + ".png");
    TRY_DONE(WriteFile(path.string(), png));
  }
  return core::Done{};
}

}  // namespace faultlab::server

#include "server/cli/reproduce.h"

#include <boost/json/array.hpp>
#include <boost/json/serialize.hpp>

#include "hardware/bench/benches.h"
#include "server/cli/console.h"
#include "server/cli/paper_pictures.h"
#include "server/json/number_or_null.h"
#include "server/plots/figure_json.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

json::value FaultJson(const std::optional<core::TableFault>& fault) {
  if (!fault) {
    return nullptr;
  }
  return json::object{{"component", core::Name(fault->component)}, {"value", fault->value}};
}

json::object RowJson(const core::TableRow& row) {
  json::object out = {{"fault", FaultJson(row.fault)},
                      {"name", row.name},
                      {"paper", NumberOrNull(row.paper)},
                      {"ours", NumberOrNull(row.ours)}};
  if (row.truth) {
    out["truth"] = NumberOrNull(*row.truth);
  }
  if (!row.erratum.empty()) {
    out["erratum"] = row.erratum;
  }
  out["compared"] = row.compared;
  return out;
}

}  // namespace

json::object ToJson(const core::Reproduction& reproduction) {
  const auto table_json = [](const core::PaperTable& table) {
    return json::object{{"table", table.table},
                        {"title", table.title},
                        {"unit", table.unit},
                        {"profile", table.profile},
                        {"settings", table.settings},
                        {"rows", ListOf(table.rows, RowJson)},
                        {"mean_relative_error", NumberOrNull(table.mean_relative_error)},
                        {"mean_difference", NumberOrNull(table.mean_difference)}};
  };
  const auto fit_json = [](const core::FitRow& fit) {
    return json::object{{"fault", FaultJson(fit.fault)},
                        {"paper_percent", NumberOrNull(fit.paper_percent)},
                        {"ours_percent", NumberOrNull(fit.ours_percent)},
                        {"truth_percent", NumberOrNull(fit.truth_percent)}};
  };
  const core::ReproductionSummary& summary = reproduction.summary;
  return {
      {"tables", ListOf(reproduction.tables, table_json)},
      {"fits", ListOf(reproduction.fits, fit_json)},
      {"summary",
       json::object{
           {"tables_7_8_mean_relative_error", NumberOrNull(summary.tables_7_8_mean_relative_error)},
           {"tables_5_6_mean_relative_error", NumberOrNull(summary.tables_5_6_mean_relative_error)},
           {"nominal_fit_swa_percent", NumberOrNull(summary.nominal_fit_swa_percent)},
           {"nominal_fit_sia_percent", NumberOrNull(summary.nominal_fit_sia_percent)},
           {"rows", summary.rows},
           {"rows_with_erratum", summary.rows_with_erratum}}}};
}

int RunReproduce(const ReproduceOptions& options) {
  if (options.repetitions < 1 || options.repetitions > 1000) {
    PrintError("--repetitions must be 1 to 1000");
    return kExitBadInput;
  }
  TRY_INPUT(const auto bench, hardware::LoadBench(options.bench));
  if (const std::string missing = core::MissingForTables(*bench); !missing.empty()) {
    PrintError("the printed tables are of the paper's bench; " + bench->name + " has not " +
               missing);
    return kExitBadInput;
  }
  core::ReproductionOptions settings;
  settings.bench = bench;
  settings.seed = options.seed;
  settings.repetitions = options.repetitions;
  const core::Reproduction reproduction = core::Reproduce(settings);
  std::vector<PaperFigure> figures;
  if (options.json || !options.plots_dir.empty()) {
    TRY_INPUT(figures, MakePaperFigures(*bench, options.seed, reproduction));
  }
  std::string text = ToText(reproduction);
  if (options.json) {
    json::object all = ToJson(reproduction);
    all["figures"] = ListOf(figures, [](const PaperFigure& each) {
      json::object out = ToJson(each.figure);
      out["number"] = each.number;
      return out;
    });
    text = json::serialize(all) + "\n";
  }
  if (Print(text) != kExitOk) {
    return kExitFailure;
  }
  return options.plots_dir.empty() ? kExitOk : Ended(DrawPaperFigures(figures, options.plots_dir));
}

}  // namespace faultlab::server

#include "server/api/run/notebook.h"

#include <boost/json.hpp>

#include "server/csv/file_io.h"
#include "server/oidc/base64url.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

constexpr std::string_view kRead = R"(import base64, csv, gzip

text = str(gzip.decompress(base64.urlsafe_b64decode(RECORDING + "==")), "utf8")
comments = [line[1:].strip() for line in text.splitlines() if line.startswith("#")]
table = list(csv.reader(line for line in text.splitlines() if line and not line.startswith("#")))
number = lambda cell: float(cell) if cell else float("nan")  # a lost reading
columns = list(zip(*table[1:])) or [()] * len(table[0])
run = {name: [number(cell) for cell in column] for name, column in zip(table[0], columns)}
print(len(table) - 1, "samples:", ", ".join(run)))";

constexpr std::string_view kDraw = R"(try:
    import matplotlib.pyplot as plt
except ImportError:
    print("matplotlib draws the figure; install it by: pip install matplotlib")
else:
    time, *signals = run
    figure, axes = plt.subplots(len(signals), sharex=True, squeeze=False, figsize=(9, 1.5 * len(signals)))
    for (axis,), name in zip(axes, signals):
        axis.plot(run[time], run[name], linewidth=0.8)
        axis.set_ylabel(name)
    axes[-1][0].set_xlabel(time)
    plt.show())";

json::object Cell(std::string_view id, std::string_view source) {
  return {{"cell_type", "code"},
          {"id", id},
          {"execution_count", nullptr},
          {"metadata", json::object{}},
          {"outputs", json::array{}},
          {"source", source}};
}

}  // namespace

std::string NotebookText(std::string_view title, std::string_view csv) {
  const std::string recording = "RECORDING = \"" + oidc::EncodeBase64Url(Gzip(csv)) + "\"";
  json::object data = Cell("recording", recording);
  data["metadata"] = json::object{{"jupyter", json::object{{"source_hidden", true}}}};
  const json::object heading{{"cell_type", "markdown"},
                             {"id", "heading"},
                             {"metadata", json::object{}},
                             {"source", title}};
  const json::object python{
      {"display_name", "Python 3"}, {"language", "python"}, {"name", "python3"}};
  return json::serialize(json::object{
      {"nbformat", 4},
      {"nbformat_minor", 5},
      {"metadata", json::object{{"kernelspec", python}}},
      {"cells", json::array{heading, data, Cell("read", kRead), Cell("draw", kDraw)}}});
}

}  // namespace faultlab::server

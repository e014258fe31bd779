// Any bytes as a recording: the reader returns a record that satisfies its contract, or an error
// with a message; it never crashes, hangs or exceeds its limits.
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "server/csv/csv_record.h"
#include "server/csv/csv_writer.h"
#include "server/csv/file_io.h"

namespace {

using namespace faultlab;  // NOLINT(google-build-using-namespace)

void Require(bool condition) {
  if (!condition) {
    std::abort();
  }
}

bool SameBits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b) ||
         (std::isnan(a) && std::isnan(b));
}

void CheckPromises(const server::CsvRecord& record) {
  Require(record.samples.size() >= 2 && record.period_s > 0.0);
  Require(record.samples.front().index == 0);
  for (std::size_t k = 1; k < record.samples.size(); ++k) {
    Require(record.samples[k].index > record.samples[k - 1].index);
    Require(record.samples[k].t_s > record.samples[k - 1].t_s);
    Require(std::isfinite(record.samples[k].uc_v) && !std::isinf(record.samples[k].um_v));
  }
}

void CheckRoundTrip(const server::CsvRecord& record) {
  const core::Result<server::CsvRecord> again =
      server::ParseCsv(server::FormatCsv(record.samples), "again");
  Require(again.ok() && again.value().samples.size() == record.samples.size());
  for (std::size_t k = 0; k < record.samples.size(); ++k) {
    const core::Sample& a = record.samples[k];
    const core::Sample& b = again.value().samples[k];
    Require(a.index == b.index && SameBits(a.t_s, b.t_s) && SameBits(a.uc_v, b.uc_v) &&
            SameBits(a.um_v, b.um_v) && SameBits(a.ua_v, b.ua_v) && SameBits(a.ia_a, b.ia_a) &&
            SameBits(a.n_rpm, b.n_rpm));
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  server::CsvLimits limits;
  limits.rows_max = 10'000;
  limits.bytes_max = 1 << 20;
  const core::Result<server::CsvRecord> record = server::ParseCsv(text, "fuzz.csv", limits);
  if (record) {
    CheckPromises(record.value());
    CheckRoundTrip(record.value());
  } else {
    Require(!record.error().message.empty());
  }
  const core::Result<std::string> inflated = server::Gunzip(text, "fuzz.csv.gz", limits.bytes_max);
  Require(!inflated || inflated.value().size() <= limits.bytes_max);
  return 0;
}

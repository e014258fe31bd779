#include "server/cli/excitation_source.h"

#include <string_view>
#include <utility>

#include "core/signals/excitation_text.h"
#include "server/csv/csv_record.h"

namespace faultlab::server {

core::Result<core::ExcitationSpec> ReadExcitation(const std::string& text, std::uint64_t seed) {
  constexpr std::string_view kFile = "file:";
  if (!text.starts_with(kFile)) {
    return core::ParseExcitation(text, seed);
  }
  TRY(const auto record, ReadCsv(text.substr(kFile.size())));
  core::SamplesSpec spec;
  for (const core::Sample& sample : record.samples) {
    spec.uc_v.push_back(sample.uc_v);
  }
  return core::ExcitationSpec(std::move(spec));
}

}  // namespace faultlab::server

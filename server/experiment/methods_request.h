#pragma once

#include <boost/json/object.hpp>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/methods/method_list.h"
#include "server/experiment/recordings.h"

namespace faultlab::server {

/// {"methods": {"recording": ID, "names": ["ekf-bank", ..], "channels": "um"|"all",
/// "healthy_from_s", "healthy_to_s"}}: what a job does that compares methods of the literature on
/// one recording. The settings are those of `faultlab diagnose --method`.
struct MethodsRequest {
  std::string recording;
  std::vector<const core::MethodInfo*> methods;  ///< empty: all that fit the bench
  core::Channels channels = core::Channels::kUmOnly;
  std::optional<double> healthy_from_s;  ///< nullopt: as the bench has it
  std::optional<double> healthy_to_s;
};

/// Errors name the field.
core::Result<MethodsRequest> ParseMethodsRequest(const boost::json::object& body);
/// May `who` read the recording, and do the methods fit its bench?
core::Status CheckMethods(Recordings& recordings,
                          const Principal& who,
                          const MethodsRequest& request);
/// {"recording", "bench", "samples", "period_s", "healthy_to_s", "of", "methods": [what `faultlab
/// diagnose --method --json` says, ..]} as text; `of` is how many methods there will be. Blocks:
/// about 5 us a sample and method, and the searches.
/// @param so_far  "", or what `keep` heard last of the same request: goes on from there
/// @param keep    hears of each method that is done, all before it included, and whether it holds
///                the turn of long recordings; its error ends the work
core::Result<std::string> CompareMethods(
    Recordings& recordings,
    const Principal& who,
    const MethodsRequest& request,
    const std::string& so_far,
    const std::function<core::Status(const std::string& so_far, bool is_long)>& keep);

}  // namespace faultlab::server

#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <string_view>

#include "server/experiment/rig_access.h"
#include "server/lab/lab_service.h"
#include "server/upkeep/rig_upkeep.h"
#include "tests/paper_bench.h"

namespace faultlab::tests {

/// Rigs as the server shares them, without HTTP: the lab, the upkeep of the rigs, and the access to
/// them. Made of the product's own parts, as in app/services.cc.
class SharedRigs {
 public:
  SharedRigs(server::Database& database, server::RigPool& rig_pool, const server::Clock& clock)
      : bands_(database),
        checks_(database),
        benches_(database, {&paper::Bench()}),
        upkeep_(rig_pool, bands_, checks_, benches_, clock, Silent, std::chrono::milliseconds(10)) {
    server::lab::LabServiceOptions options;
    options.member = "local";
    options.alone = true;
    auto service = server::lab::LabService::Open(database, clock, upkeep_, std::move(options));
    service_ = std::move(service).value();
    access_ = std::make_unique<server::RigAccess>(*service_, rig_pool, clock, Silent);
    upkeep_.Start(*service_);
  }
  ~SharedRigs() { upkeep_.Stop(); }
  SharedRigs(const SharedRigs&) = delete;
  SharedRigs& operator=(const SharedRigs&) = delete;

  server::lab::LabService& service() { return *service_; }
  server::RigAccess& access() { return *access_; }
  void Stop() { upkeep_.Stop(); }

 private:
  static void Silent(std::string_view) {}

  server::lab::RigBands bands_;
  server::lab::CheckLog checks_;
  server::Benches benches_;
  server::RigUpkeep upkeep_;
  std::unique_ptr<server::lab::LabService> service_;
  std::unique_ptr<server::RigAccess> access_;
};

}  // namespace faultlab::tests

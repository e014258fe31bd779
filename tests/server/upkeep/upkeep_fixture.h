#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <utility>

#include "server/lab/lab_service.h"
#include "tests/world/faulty_store.h"
#include "tests/world/memory_store.h"

namespace faultlab::server {

/// The lab of one server, in memory, on a clock that stands.
class UpkeepFixture : public testing::Test, public lab::RigDuties {
 protected:
  UpkeepFixture() { RestartTheLab(); }
  void RestartTheLab() {
    using namespace lab::rehearsal;
    lab_.reset();
    lab::LabServiceOptions options;
    options.own_thread = false;
    auto store = std::make_unique<MemoryStore>(stored_, false, [this] { return clock_.Wall(); });
    lab_ = lab::LabService::Open(std::make_unique<FaultyStore>(std::move(store), faults_),
                                 clock_,
                                 *this,
                                 std::move(options))
               .value();
  }
  void Fence(const lab::RigId&, std::uint64_t) override {}
  void StartCleaning(const lab::Lease& lease) override { asked_ = lease; }
  lab::Rig RigNow(const lab::RigId& id) const { return lab_->state()->rigs.at(id); }

  ManualClock clock_;
  lab::rehearsal::StoreFaults faults_;
  lab::Lease asked_;  ///< the check that the lab asked for last
  std::unique_ptr<lab::LabService> lab_;

 private:
  const std::shared_ptr<lab::rehearsal::MemoryLab> stored_ =
      std::make_shared<lab::rehearsal::MemoryLab>();
};

}  // namespace faultlab::server

#pragma once

#include <gtest/gtest.h>

#include <string>

#include "server/storage/database.h"

namespace faultlab::tests {

inline const auto kBothEngines =
    ::testing::Values(server::Engine::kSqlite, server::Engine::kPostgresql);

inline std::string EngineName(const ::testing::TestParamInfo<server::Engine>& info) {
  return info.param == server::Engine::kSqlite ? "Sqlite" : "Postgresql";
}

}  // namespace faultlab::tests

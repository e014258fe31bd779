#pragma once

#include <array>
#include <string_view>

#include "server/storage/recording_store.h"

// Rows of recordings and of their events, as rows.h reads and writes them.
namespace faultlab::server {

/// By RunState.
inline constexpr std::array<std::string_view, 5> kRunStates = {
    "running", "finished", "stopped", "failed", "interrupted"};

template <typename Visit>
void Fields(RunRecord& run, Visit&& visit) {
  visit("id", run.id);
  visit("name", run.name);
  visit("owner", run.owner);
  visit("rig", run.rig);
  visit("source", run.source);
  visit("server_id", run.server_id);
  visit("epoch", run.epoch);
  visit("bench", run.bench);
  visit("period_s", run.period_s);
  visit("plan_json", run.plan_json);
  visit("options_json", run.options_json);
  visit("state", run.state, kRunStates);
  visit("created_ms", run.created_at);
  visit("ended_ms", run.ended_at);
  visit("samples", run.samples);
  visit("diagnosis_json", run.diagnosis_json);
  visit("verdict", run.verdict);
  visit("kept_run", run.kept_run);
  visit("note", run.note);
}

template <typename Visit>
void Fields(RecordedEvent& event, Visit&& visit) {
  visit("sample_index", event.index);
  visit("kind", event.kind);
  visit("json", event.json);
}

}  // namespace faultlab::server

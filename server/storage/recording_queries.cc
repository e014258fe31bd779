// What is asked about recordings; recording_store.cc holds what changes them.
#include <algorithm>
#include <charconv>
#include <string_view>
#include <utility>

#include "server/storage/blob_store.h"
#include "server/storage/chunk_codec.h"
#include "server/storage/not_yours.h"
#include "server/storage/recording_rows.h"
#include "server/storage/recording_store.h"
#include "server/storage/rows.h"
#include "server/storage/text_search.h"

namespace faultlab::server {
namespace {

using core::Done;

constexpr int kPageMax = 500;
/// "R1": as the name of a component it is not the beginning of another one, "R12".
bool IsSymbol(std::string_view text) {
  const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  const auto number = std::ranges::find_if_not(text, letter);
  constexpr std::ptrdiff_t kLettersMax = 2;
  const auto letters = number - text.begin();
  return letters > 0 && letters <= kLettersMax && number != text.end() &&
         std::all_of(number, text.end(), digit);
}

/// What the text of a search is looked for in. Of a symbol, longer ones do not count.
std::string SearchedText(std::string_view text) {
  std::string searched = "LOWER(name || ' ' || note || ' ' || id)";
  if (!IsSymbol(text)) return searched;
  std::string symbol;
  for (const char c : text) symbol += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  for (char next = '0'; next <= '9'; ++next) {
    searched = "REPLACE(" + searched + ", '" + symbol + next + "', ' ')";
  }
  return searched;
}

struct Cursor {
  std::int64_t created_ms = 0;
  std::string id;
};

/// "1763688460000.run-abc": time and id of the last item, newest first.
std::optional<Cursor> ParseCursor(const std::string& text) {
  Cursor cursor;
  const auto [end, error] =
      std::from_chars(text.data(), text.data() + text.size(), cursor.created_ms);
  if (error != std::errc{} || end == text.data() + text.size() || *end != '.') return std::nullopt;
  cursor.id.assign(end + 1, text.data() + text.size());
  if (cursor.id.empty()) return std::nullopt;
  return cursor;
}

}  // namespace

core::Result<std::vector<RunRecord>> RecordingStore::AwaitingRecovery() {
  return database_.Read([&](Transaction& tx) {
    return SelectRows<RunRecord>(tx,
                                 "recording WHERE state = 'interrupted' AND kept_run <> '' "
                                 "ORDER BY created_ms DESC, id");
  });
}

core::Result<std::int64_t> RecordingStore::SamplesOf(const std::string& owner) {
  return database_.Read([&](Transaction& tx) {
    const auto samples = *SelectValue<std::int64_t>(
        tx,
        "SELECT CAST(COALESCE(SUM(CASE WHEN samples < :least THEN :least ELSE samples END), 0) AS "
        "BIGINT) FROM recording WHERE owner = :owner",
        {{"least", kSamplesLeast}, {"owner", owner}});
    const auto picture_bytes = *SelectValue<std::int64_t>(
        tx,
        "SELECT CAST(COALESCE(SUM(p.size_bytes), 0) AS BIGINT) FROM recording_picture p "
        "JOIN recording r ON r.id = p.recording_id WHERE r.owner = :owner",
        {{"owner", owner}});
    return samples + picture_bytes / kSampleBytes;
  });
}

core::Result<std::optional<std::string>> RecordingStore::OldestEndedOf(const std::string& owner) {
  return database_.Read([&](Transaction& tx) {
    return SelectValue<std::string>(
        tx,
        "SELECT id FROM recording WHERE owner = :owner AND state <> 'running' "
        "AND NOT (state = 'interrupted' AND kept_run <> '') ORDER BY created_ms, id LIMIT 1",
        {{"owner", owner}});
  });
}

core::Result<std::set<std::string>> RecordingStore::StarredOf(
    const std::string& who, std::span<const std::string> run_ids) {
  using Ids = std::set<std::string>;
  return database_.Read([&](Transaction& tx) {
    Ids out;
    for (const std::string& run_id : run_ids) {
      if (CountRows(tx,
                    "recording_star WHERE recording_id = :id AND who = :who",
                    {{"id", run_id}, {"who", who}}) > 0) {
        out.insert(run_id);
      }
    }
    return out;
  });
}

core::Result<std::map<std::string, std::vector<RecordedEvent>>> RecordingStore::EventsOf(
    std::span<const std::string> run_ids, std::span<const std::string_view> kinds, int most) {
  using Events = std::map<std::string, std::vector<RecordedEvent>>;
  std::string words;
  for (const std::string_view kind : kinds) {
    words.append(words.empty() ? "'" : ", '").append(kind).append("'");
  }
  return database_.Read([&](Transaction& tx) {
    Events out;
    for (const std::string& run_id : run_ids) {
      std::vector<RecordedEvent>& of = out[run_id];
      of = SelectRows<RecordedEvent>(tx,
                                     "recording_event WHERE recording_id = :id AND kind IN (" +
                                         words + ") ORDER BY seq DESC LIMIT :most",
                                     {{"id", run_id}, {"most", most}});
      std::ranges::reverse(of);
    }
    return out;
  });
}

core::Result<RunRecord> RecordingStore::Get(const std::string& run_id) {
  return database_.Read([&](Transaction& tx) -> core::Result<RunRecord> {
    auto found = SelectRow<RunRecord>(tx, "recording WHERE id = :id", {{"id", run_id}});
    if (!found) return NotYours();
    return std::move(*found);
  });
}

core::Result<std::optional<std::string>> RecordingStore::RunningOn(const std::string& rig) {
  return database_.Read([&](Transaction& tx) {
    return SelectValue<std::string>(tx,
                                    "SELECT id FROM recording WHERE rig = :rig AND "
                                    "state = 'running' ORDER BY created_ms DESC LIMIT 1",
                                    {{"rig", rig}});
  });
}

core::Result<std::optional<std::string>> RecordingStore::NewestOf(const std::string& owner,
                                                                  const std::string& rig,
                                                                  WallTime from,
                                                                  WallTime to) {
  return database_.Read([&](Transaction& tx) {
    return SelectValue<std::string>(
        tx,
        "SELECT id FROM recording WHERE owner = :owner AND rig = :rig AND "
        "created_ms BETWEEN :from AND :to ORDER BY created_ms DESC, id DESC LIMIT 1",
        {{"owner", owner}, {"rig", rig}, {"from", from}, {"to", to}});
  });
}

core::Result<RunPage> RecordingStore::List(const std::string& cursor,
                                           int limit,
                                           const RunFilter& filter) {
  if (limit < 1 || limit > kPageMax) {
    return core::Refuse("whole_number_outside",
                        "limit",
                        {{"member", "limit"}, {"lowest", 1}, {"highest", kPageMax}});
  }
  const auto after = ParseCursor(cursor);
  if (!cursor.empty() && !after) {
    return core::Refuse("cursor_foreign", "cursor");
  }
  return database_.Read([&](Transaction& tx) -> core::Result<RunPage> {
    Condition which;
    if (filter.owner) which.And("owner = :owner", {{"owner", *filter.owner}});
    if (filter.source) which.And("source = :source", {{"source", *filter.source}});
    if (filter.course) {
      which.And(
          "EXISTS (SELECT 1 FROM enrolment e WHERE e.course_id = :course AND e.teaches = 0 "
          "AND owner = 'user:' || e.account_id AND created_ms >= e.since_ms)",
          {{"course", *filter.course}});
    }
    if (filter.text) {
      which.And(ContainsSql(tx, SearchedText(*filter.text), "text"), {{"text", *filter.text}});
    }
    if (filter.rig) which.And("rig = :rig", {{"rig", *filter.rig}});
    // A run whose faults were all set back ends healthy, and had faults.
    const Parameter had_fault("had", R"(%"verdict":"fault"%)");
    if (filter.verdict == "fault") {
      which.And("(verdict = 'fault' OR diagnosis_json LIKE :had)", {had_fault});
    } else if (filter.verdict == "nominal") {
      which.And("verdict = 'nominal' AND diagnosis_json NOT LIKE :had", {had_fault});
    } else if (filter.verdict) {
      which.And("verdict = :verdict", {{"verdict", *filter.verdict}});
    }
    if (filter.starred_by) {
      which.And(
          "EXISTS (SELECT 1 FROM recording_star s WHERE s.recording_id = id AND s.who = :who)",
          {{"who", *filter.starred_by}});
    }
    if (after) {
      which.And("(created_ms, id) < (:before, :id)",
                {{"before", after->created_ms}, {"id", after->id}});
    }
    RunPage page;
    page.items = SelectRows<RunRecord>(tx,
                                       "recording WHERE " + which.sql +
                                           " ORDER BY created_ms DESC, id DESC LIMIT " +
                                           std::to_string(limit + 1),
                                       which.parameters);
    if (page.items.size() > static_cast<std::size_t>(limit)) {
      page.items.pop_back();
      const RunRecord& last = page.items.back();
      page.next_cursor = std::to_string(ToMilliseconds(last.created_at)) + "." + last.id;
    }
    return page;
  });
}

core::Result<std::vector<core::Sample>> RecordingStore::LoadSamples(const std::string& run_id,
                                                                    std::int64_t from,
                                                                    std::int64_t to) {
  using Samples = std::vector<core::Sample>;
  return database_.Read([&](Transaction& tx) -> core::Result<Samples> {
    if (CountRows(tx, "recording WHERE id = :id", {{"id", run_id}}) == 0) return NotYours();
    Samples out;
    core::Status status = Done{};
    const std::string owner = RecordingBlobs(run_id);
    const std::int64_t first = blob_store::SequenceAtOrBefore(tx, owner, from).value_or(from);
    blob_store::ForEach(tx, owner, first, to, [&](std::int64_t, const Bytes& bytes) {
      auto chunk = DecodeChunk(bytes);
      if (!chunk.ok()) {
        status = chunk.error();
        return false;
      }
      for (const auto& sample : chunk.value()) {
        if (sample.index >= from && sample.index < to) out.push_back(sample);
      }
      return true;
    });
    if (!status.ok()) return status.error();
    return out;
  });
}

core::Result<std::vector<RecordedEvent>> RecordingStore::LoadEvents(const std::string& run_id) {
  return database_.Read([&](Transaction& tx) {
    return SelectRows<RecordedEvent>(
        tx, "recording_event WHERE recording_id = :id ORDER BY seq", {{"id", run_id}});
  });
}

}  // namespace faultlab::server

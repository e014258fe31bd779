// What is asked about recordings; recording_store.cc holds what changes them.
#include <soci/soci.h>

#include <algorithm>
#include <charconv>
#include <string_view>
#include <utility>

#include "core/types/check.h"
#include "server/storage/blob_store.h"
#include "server/storage/chunk_codec.h"
#include "server/storage/not_yours.h"
#include "server/storage/recording_store.h"
#include "server/storage/text_search.h"

namespace faultlab::server {
namespace {

using core::Done;
using core::Error;
using core::ErrorCode;
using soci::into;
using soci::use;

constexpr int kPageMax = 500;
constexpr const char* kColumns =
    "id, name, owner, rig, source, server_id, epoch, bench, period_s, plan_json, options_json, "
    "state, created_ms, ended_ms, samples, diagnosis_json, verdict, kept_run, note ";

/// The row of kColumns, and its conversion to a record.
struct Row {
  RunRecord record;
  std::int64_t epoch = 0;
  std::string state;
  std::int64_t created_ms = 0;
  std::int64_t ended_ms = 0;
  soci::indicator ended_indicator = soci::i_null;

  template <typename Statement>
  void BindInto(Statement& statement) {
    statement.exchange(into(record.id));
    statement.exchange(into(record.name));
    statement.exchange(into(record.owner));
    statement.exchange(into(record.rig));
    statement.exchange(into(record.source));
    statement.exchange(into(record.server_id));
    statement.exchange(into(epoch));
    statement.exchange(into(record.bench));
    statement.exchange(into(record.period_s));
    statement.exchange(into(record.plan_json));
    statement.exchange(into(record.options_json));
    statement.exchange(into(state));
    statement.exchange(into(created_ms));
    statement.exchange(into(ended_ms, ended_indicator));
    statement.exchange(into(record.samples));
    statement.exchange(into(record.diagnosis_json));
    statement.exchange(into(record.verdict));
    statement.exchange(into(record.kept_run));
    statement.exchange(into(record.note));
  }

  RunRecord ToRecord() const {
    RunRecord out = record;
    out.epoch = static_cast<std::uint64_t>(epoch);
    const auto parsed = ParseRunState(state);
    LAB_CHECK(parsed.has_value(), state);
    out.state = *parsed;
    out.created_at = FromMilliseconds(created_ms);
    if (ended_indicator == soci::i_ok) out.ended_at = FromMilliseconds(ended_ms);
    return out;
  }
};

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
  return database_.Read([&](Transaction& tx) -> core::Result<std::vector<RunRecord>> {
    Row row;
    soci::statement statement(tx.sql());
    row.BindInto(statement);
    statement.alloc();
    statement.prepare(std::string("SELECT ") + kColumns +
                      "FROM recording WHERE state = 'interrupted' AND kept_run <> '' "
                      "ORDER BY created_ms DESC, id");
    statement.define_and_bind();
    statement.execute(false);
    std::vector<RunRecord> records;
    while (statement.fetch()) records.push_back(row.ToRecord());
    return records;
  });
}

core::Result<std::int64_t> RecordingStore::SamplesOf(const std::string& owner) {
  return database_.Read([&](Transaction& tx) -> core::Result<std::int64_t> {
    std::int64_t samples = 0;
    std::int64_t picture_bytes = 0;
    const std::int64_t least = kSamplesLeast;
    tx.sql() << "SELECT CAST(COALESCE(SUM(CASE WHEN samples < :least THEN :same ELSE samples END), "
                "0) AS BIGINT) FROM recording WHERE owner = :owner",
        into(samples), use(least, "least"), use(least, "same"), use(owner, "owner");
    tx.sql() << "SELECT CAST(COALESCE(SUM(p.size_bytes), 0) AS BIGINT) FROM recording_picture p "
                "JOIN recording r ON r.id = p.recording_id WHERE r.owner = :owner",
        into(picture_bytes), use(owner, "owner");
    return samples + picture_bytes / kSampleBytes;
  });
}

core::Result<std::optional<std::string>> RecordingStore::OldestEndedOf(const std::string& owner) {
  return database_.Read([&](Transaction& tx) -> core::Result<std::optional<std::string>> {
    std::string id;
    tx.sql() << "SELECT id FROM recording WHERE owner = :owner AND state <> 'running' "
                "AND NOT (state = 'interrupted' AND kept_run <> '') "
                "ORDER BY created_ms, id LIMIT 1",
        into(id), use(owner, "owner");
    return tx.sql().got_data() ? std::optional<std::string>(id) : std::nullopt;
  });
}

core::Result<std::set<std::string>> RecordingStore::StarredOf(
    const std::string& who, std::span<const std::string> run_ids) {
  using Ids = std::set<std::string>;
  return database_.Read([&](Transaction& tx) -> core::Result<Ids> {
    Ids out;
    for (const std::string& run_id : run_ids) {
      long long found = 0;
      tx.sql() << "SELECT COUNT(*) FROM recording_star WHERE recording_id = :id AND who = :who",
          into(found), use(run_id, "id"), use(who, "who");
      if (found > 0) out.insert(run_id);
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
  return database_.Read([&](Transaction& tx) -> core::Result<Events> {
    Events out;
    for (const std::string& run_id : run_ids) {
      RecordedEvent event;
      soci::statement statement =
          (tx.sql().prepare << "SELECT sample_index, kind, json FROM recording_event "
                               "WHERE recording_id = :id AND kind IN (" +
                                   words + ") ORDER BY seq DESC LIMIT :most",
           into(event.index),
           into(event.kind),
           into(event.json),
           use(run_id, "id"),
           use(most, "most"));
      statement.execute(false);
      std::vector<RecordedEvent>& of = out[run_id];
      while (statement.fetch()) of.push_back(event);
      std::reverse(of.begin(), of.end());
    }
    return out;
  });
}

core::Result<RunRecord> RecordingStore::Get(const std::string& run_id) {
  return database_.Read([&](Transaction& tx) -> core::Result<RunRecord> {
    Row row;
    soci::statement statement(tx.sql());
    row.BindInto(statement);
    statement.exchange(use(run_id, "id"));
    statement.alloc();
    statement.prepare(std::string("SELECT ") + kColumns + "FROM recording WHERE id = :id");
    statement.define_and_bind();
    if (!statement.execute(true)) return NotYours();
    return row.ToRecord();
  });
}

core::Result<std::optional<std::string>> RecordingStore::RunningOn(const std::string& rig) {
  using MaybeRun = std::optional<std::string>;
  return database_.Read([&](Transaction& tx) -> core::Result<MaybeRun> {
    std::string id;
    tx.sql() << "SELECT id FROM recording WHERE rig = :rig AND state = 'running' "
                "ORDER BY created_ms DESC LIMIT 1",
        into(id), use(rig, "rig");
    return tx.sql().got_data() ? MaybeRun(id) : MaybeRun();
  });
}

core::Result<std::optional<std::string>> RecordingStore::NewestOf(const std::string& owner,
                                                                  const std::string& rig,
                                                                  WallTime from,
                                                                  WallTime to) {
  using MaybeRun = std::optional<std::string>;
  return database_.Read([&](Transaction& tx) -> core::Result<MaybeRun> {
    std::string id;
    const std::int64_t from_ms = ToMilliseconds(from);
    const std::int64_t to_ms = ToMilliseconds(to);
    tx.sql() << "SELECT id FROM recording WHERE owner = :owner AND rig = :rig AND "
                "created_ms BETWEEN :from AND :to ORDER BY created_ms DESC, id DESC LIMIT 1",
        into(id), use(owner, "owner"), use(rig, "rig"), use(from_ms, "from"), use(to_ms, "to");
    return tx.sql().got_data() ? MaybeRun(id) : MaybeRun();
  });
}

core::Result<RunPage> RecordingStore::List(const std::string& cursor,
                                           int limit,
                                           const RunFilter& filter) {
  if (limit < 1 || limit > kPageMax) {
    return Error{ErrorCode::kInvalid,
                 "limit must be 1 to 500",
                 "limit",
                 "number_outside",
                 {{"member", "limit"}, {"lowest", "1"}, {"highest", "500"}}};
  }
  const auto after = ParseCursor(cursor);
  if (!cursor.empty() && !after) {
    return Error{ErrorCode::kInvalid,
                 "this cursor does not come from this list",
                 "cursor",
                 "cursor_foreign"};
  }
  return database_.Read([&](Transaction& tx) -> core::Result<RunPage> {
    std::string query = std::string("SELECT ") + kColumns + "FROM recording WHERE 1 = 1";
    const int fetch = limit + 1;
    Row row;
    soci::statement statement(tx.sql());
    row.BindInto(statement);
    if (filter.owner) {
      query += " AND owner = :owner";
      statement.exchange(use(*filter.owner, "owner"));
    }
    if (filter.source) {
      query += " AND source = :source";
      statement.exchange(use(*filter.source, "source"));
    }
    if (filter.course) {
      query +=
          " AND EXISTS (SELECT 1 FROM enrolment e WHERE e.course_id = :course AND e.teaches = 0 "
          "AND owner = 'user:' || e.account_id AND created_ms >= e.since_ms)";
      statement.exchange(use(*filter.course, "course"));
    }
    if (filter.text) {
      query += " AND " + ContainsSql(tx, SearchedText(*filter.text), "text");
      statement.exchange(use(*filter.text, "text"));
    }
    if (filter.rig) {
      query += " AND rig = :rig";
      statement.exchange(use(*filter.rig, "rig"));
    }
    // A run whose faults were all set back ends healthy, and had faults.
    static const std::string kHadFault = R"(%"verdict":"fault"%)";
    if (filter.verdict == "fault") {
      query += " AND (verdict = 'fault' OR diagnosis_json LIKE :had)";
      statement.exchange(use(kHadFault, "had"));
    } else if (filter.verdict == "nominal") {
      query += " AND verdict = 'nominal' AND diagnosis_json NOT LIKE :had";
      statement.exchange(use(kHadFault, "had"));
    } else if (filter.verdict) {
      query += " AND verdict = :verdict";
      statement.exchange(use(*filter.verdict, "verdict"));
    }
    if (filter.starred_by) {
      query +=
          " AND EXISTS (SELECT 1 FROM recording_star s WHERE s.recording_id = id AND s.who = :who)";
      statement.exchange(use(*filter.starred_by, "who"));
    }
    if (after) {
      query += " AND (created_ms < :before OR (created_ms = :same AND id < :id))";
      statement.exchange(use(after->created_ms, "before"));
      statement.exchange(use(after->created_ms, "same"));
      statement.exchange(use(after->id, "id"));
    }
    query += " ORDER BY created_ms DESC, id DESC LIMIT :fetch";
    statement.exchange(use(fetch, "fetch"));
    statement.alloc();
    statement.prepare(query);
    statement.define_and_bind();
    statement.execute(false);
    RunPage page;
    while (statement.fetch()) page.items.push_back(row.ToRecord());
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
    long long known = 0;
    tx.sql() << "SELECT COUNT(*) FROM recording WHERE id = :id", into(known), use(run_id, "id");
    if (known == 0) return NotYours();
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
  using Events = std::vector<RecordedEvent>;
  return database_.Read([&](Transaction& tx) -> core::Result<Events> {
    RecordedEvent event;
    soci::statement statement =
        (tx.sql().prepare << "SELECT sample_index, kind, json FROM recording_event "
                             "WHERE recording_id = :id ORDER BY seq",
         into(event.index),
         into(event.kind),
         into(event.json),
         use(run_id, "id"));
    statement.execute(false);
    Events out;
    while (statement.fetch()) out.push_back(event);
    return out;
  });
}

}  // namespace faultlab::server

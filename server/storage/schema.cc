#include <string_view>

#include "server/storage/migrations.h"

namespace faultlab::server {
namespace {

constexpr std::string_view kSchema =
#include "server/storage/schema.inc"
    ;

/// The statements of schema.sql: one a paragraph, ended by a semicolon.
Migration FirstSchema() {
  Migration out{.version = 32,  // as of the last step before the steps became this one
                .description = "copies of sealed records",
                .statements = {}};
  std::string_view rest = kSchema;
  while (!rest.empty()) {
    const std::size_t end = rest.find("\n\n");
    std::string_view paragraph = rest.substr(0, end);
    rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 2);
    while (paragraph.starts_with('\n')) paragraph.remove_prefix(1);
    if (paragraph.empty() || paragraph.starts_with("--")) continue;
    Statement statement{.text = {}, .engine = std::nullopt};
    for (const auto& [word, engine] : {std::pair{std::string_view("sqlite: "), Engine::kSqlite},
                                       {std::string_view("postgresql: "), Engine::kPostgresql}}) {
      if (!paragraph.starts_with(word)) continue;
      statement.engine = engine;
      paragraph.remove_prefix(word.size());
    }
    statement.text = paragraph.substr(0, paragraph.rfind(';'));
    out.statements.push_back(std::move(statement));
  }
  return out;
}

}  // namespace

const std::vector<Migration>& AllMigrations() {
  static const std::vector<Migration> kAll = {
      FirstSchema(),
      {33,
       "when a session ended",
       {{"ALTER TABLE lab_session ADD COLUMN ended_ms BIGINT NOT NULL DEFAULT 0", std::nullopt},
        {"CREATE INDEX session_by_user ON lab_session (user_id, id)", std::nullopt}}},
  };
  return kAll;
}

}  // namespace faultlab::server

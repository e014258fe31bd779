#include <string>
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

/// The end of a run or a job is noted in the transaction that ends it, wherever that is written,
/// for whoever has a webhook of their own. server/notify tells of it and deletes the row.
std::vector<Statement> WebhooksOfPeople() {
  const auto note = [](const std::string& kind) {
    return "INSERT INTO ended (kind, subject, account_id) SELECT DISTINCT " + kind +
           ", NEW.id, account_id FROM webhook WHERE account_id > 0 AND 'user:' || account_id = "
           "NEW.owner; ";
  };
  std::vector<Statement> out = {
      {"ALTER TABLE webhook ADD COLUMN account_id BIGINT NOT NULL DEFAULT 0", std::nullopt},
      {"CREATE TABLE ended (id $ID, kind TEXT NOT NULL, subject TEXT NOT NULL, account_id BIGINT "
       "NOT NULL)",
       std::nullopt},
      {"CREATE FUNCTION note_end() RETURNS trigger LANGUAGE plpgsql AS $body$ BEGIN " +
           note("TG_ARGV[0]") + "RETURN NULL; END $body$",
       Engine::kPostgresql}};
  const auto add = [&](const std::string& kind, const std::string& table, const char* going_on) {
    const std::string trigger =
        "CREATE TRIGGER " + kind + "_has_ended AFTER UPDATE OF state ON " + table;
    const std::string when =
        std::string("OLD.state IN (") + going_on + ") AND NEW.state NOT IN (" + going_on + ")";
    out.push_back(
        {trigger + " WHEN " + when + " BEGIN " + note("'" + kind + "'") + "END", Engine::kSqlite});
    out.push_back(
        {trigger + " FOR EACH ROW WHEN (" + when + ") EXECUTE FUNCTION note_end('" + kind + "')",
         Engine::kPostgresql});
  };
  add("run", "recording", "'running'");
  add("job", "job", "'waiting', 'running'");
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
      {34,
       "learning platforms",
       {{"CREATE TABLE lti_platform (id $ID, label TEXT NOT NULL, issuer TEXT NOT NULL, client_id "
         "TEXT NOT NULL, deployment TEXT NOT NULL, auth_url TEXT NOT NULL, token_url TEXT NOT "
         "NULL, "
         "keys_url TEXT NOT NULL, makes_teachers BIGINT NOT NULL, claims_class_lists BIGINT NOT "
         "NULL, created_ms BIGINT NOT NULL)",
         std::nullopt},
        {"CREATE UNIQUE INDEX lti_platform_by_client ON lti_platform (issuer, client_id)",
         std::nullopt},
        {"CREATE TABLE lti_key (id BIGINT PRIMARY KEY, kid TEXT NOT NULL, pem TEXT NOT NULL, "
         "created_ms BIGINT NOT NULL)",
         std::nullopt},
        {"CREATE TABLE lti_seat (platform_id BIGINT NOT NULL, assignment_id BIGINT NOT NULL, "
         "account_id BIGINT NOT NULL, subject TEXT NOT NULL, lineitem TEXT NOT NULL, due BIGINT "
         "NOT "
         "NULL, PRIMARY KEY (platform_id, assignment_id, account_id))",
         std::nullopt},
        {"CREATE INDEX lti_seat_due ON lti_seat (due)", std::nullopt},
        {"CREATE INDEX lti_seat_by_person ON lti_seat (assignment_id, account_id)", std::nullopt}}},
      {35,
       "hints of blind trials",
       {{"ALTER TABLE trial ADD COLUMN hints TEXT NOT NULL DEFAULT '[]'", std::nullopt}}},
      {36,
       "trials by which a teacher tries an exercise",
       {{"ALTER TABLE trial ADD COLUMN tried BIGINT NOT NULL DEFAULT 0", std::nullopt}}},
      {37,
       "who is in a learning platform's courses",
       {{"CREATE TABLE lti_roster (platform_id BIGINT NOT NULL, course_id BIGINT NOT NULL, url "
         "TEXT NOT NULL, PRIMARY KEY (platform_id, course_id, url))",
         std::nullopt}}},
      {38,
       "hours of rig classes",
       {{"CREATE TABLE lab_window (id BIGINT PRIMARY KEY, rig_class TEXT NOT NULL, course_id "
         "BIGINT "
         "NOT NULL, title TEXT NOT NULL, repeat_rule TEXT NOT NULL, time_zone TEXT NOT NULL, times "
         "TEXT NOT NULL)",
         std::nullopt},
        {"ALTER TABLE lab_ticket ADD COLUMN courses TEXT NOT NULL DEFAULT ''", std::nullopt},
        {"ALTER TABLE lab_booking ADD COLUMN courses TEXT NOT NULL DEFAULT ''", std::nullopt},
        {"ALTER TABLE lab_session ADD COLUMN courses TEXT NOT NULL DEFAULT ''", std::nullopt}}},
      {39, "webhooks of people", WebhooksOfPeople()},
      {40,
       "reports of use",
       {{"CREATE INDEX session_by_start ON lab_session (start_ms)", std::nullopt},
        {"CREATE INDEX booking_by_start ON lab_booking (start_ms)", std::nullopt}}},
  };
  return kAll;
}

}  // namespace faultlab::server

#include <utility>

#include "server/storage/migrations.h"

namespace faultlab::server {
namespace {

Migration Recordings() {
  return {.version = 1,
          .description = "recordings: record, chunks, events",
          .statements =
              {"CREATE TABLE recording ("
               "id TEXT PRIMARY KEY, name TEXT NOT NULL, owner TEXT NOT NULL, rig TEXT NOT NULL, "
               "source TEXT NOT NULL, server_id TEXT NOT NULL, epoch BIGINT NOT NULL, "
               "period_s DOUBLE PRECISION NOT NULL, plan_json TEXT NOT NULL, state TEXT NOT NULL, "
               "created_ms BIGINT NOT NULL, ended_ms BIGINT, samples BIGINT NOT NULL, "
               "next_index BIGINT NOT NULL, diagnosis_json TEXT NOT NULL, verdict TEXT NOT NULL)",
               "CREATE INDEX recording_by_time ON recording (created_ms, id)",
               "CREATE INDEX recording_by_owner ON recording (owner, created_ms, id)",
               "CREATE TABLE recording_event ("
               "recording_id TEXT NOT NULL REFERENCES recording (id) ON DELETE CASCADE, "
               "seq BIGINT NOT NULL, sample_index BIGINT NOT NULL, kind TEXT NOT NULL, "
               "json TEXT NOT NULL, PRIMARY KEY (recording_id, seq))",
               "CREATE TABLE blob_store ("
               "owner TEXT NOT NULL, seq BIGINT NOT NULL, bytes $BLOB NOT NULL, "
               "PRIMARY KEY (owner, seq))"},
          .sqlite_statements = {},
          .postgres_statements = {}};
}

Migration Accounts() {
  return {
      .version = 2,
      .description = "accounts: users, sign-ins, keys, links, courses, audit log",
      .statements =
          {"CREATE TABLE account (id $ID, login TEXT NOT NULL UNIQUE, name TEXT NOT NULL, "
           "role TEXT NOT NULL, password_hash TEXT NOT NULL, disabled BIGINT NOT NULL, "
           "created_ms BIGINT NOT NULL, version BIGINT NOT NULL)",
           "CREATE TABLE sign_in (token_hash TEXT PRIMARY KEY, "
           "account_id BIGINT NOT NULL REFERENCES account (id), csrf TEXT NOT NULL, "
           "created_ms BIGINT NOT NULL, expires_ms BIGINT NOT NULL, address TEXT NOT NULL)",
           "CREATE TABLE api_key (id $ID, account_id BIGINT NOT NULL REFERENCES account (id), "
           "name TEXT NOT NULL, key_hash TEXT NOT NULL UNIQUE, scopes TEXT NOT NULL, "
           "created_ms BIGINT NOT NULL, expires_ms BIGINT NOT NULL, revoked BIGINT NOT NULL)",
           "CREATE TABLE one_time_link (token_hash TEXT PRIMARY KEY, "
           "account_id BIGINT NOT NULL REFERENCES account (id), expires_ms BIGINT NOT NULL, "
           "used BIGINT NOT NULL)",
           "CREATE TABLE course (id $ID, name TEXT NOT NULL, created_ms BIGINT NOT NULL)",
           "CREATE TABLE enrolment (course_id BIGINT NOT NULL REFERENCES course (id), "
           "account_id BIGINT NOT NULL REFERENCES account (id), teaches BIGINT NOT NULL, "
           "PRIMARY KEY (course_id, account_id))",
           "CREATE TABLE audit_log (seq $ID, at_ms BIGINT NOT NULL, actor TEXT NOT NULL, "
           "verb TEXT NOT NULL, object TEXT NOT NULL, detail TEXT NOT NULL)"},
      .sqlite_statements = {"CREATE TRIGGER audit_log_is_append_only_1 BEFORE UPDATE ON audit_log "
                            "BEGIN SELECT RAISE(ABORT, 'the audit log is append-only'); END",
                            "CREATE TRIGGER audit_log_is_append_only_2 BEFORE DELETE ON audit_log "
                            "BEGIN SELECT RAISE(ABORT, 'the audit log is append-only'); END"},
      .postgres_statements = {
          "CREATE FUNCTION refuse_change() RETURNS trigger LANGUAGE plpgsql AS "
          "$body$ BEGIN RAISE EXCEPTION 'the audit log is append-only'; END $body$",
          "CREATE TRIGGER audit_log_is_append_only BEFORE UPDATE OR DELETE ON audit_log "
          "FOR EACH ROW EXECUTE FUNCTION refuse_change()"}};
}

Migration Lab() {
  return {
      .version = 3,
      .description = "lab: rigs, queue, calendar, sessions, events",
      .statements =
          {"CREATE TABLE lab_meta (id BIGINT PRIMARY KEY, version BIGINT NOT NULL, "
           "next_id BIGINT NOT NULL)",
           "INSERT INTO lab_meta (id, version, next_id) VALUES (1, 0, 1)",
           "CREATE TABLE lab_rig (id TEXT PRIMARY KEY, rig_class TEXT NOT NULL, "
           "elastic BIGINT NOT NULL, status BIGINT NOT NULL, epoch BIGINT NOT NULL, "
           "cleaning_due_ms BIGINT NOT NULL, wear_ms BIGINT NOT NULL, reason TEXT NOT NULL)",
           "CREATE TABLE lab_outage (id BIGINT PRIMARY KEY, rig TEXT NOT NULL, "
           "start_ms BIGINT NOT NULL, end_ms BIGINT NOT NULL, reason TEXT NOT NULL)",
           "CREATE TABLE lab_ticket (id BIGINT PRIMARY KEY, user_id BIGINT NOT NULL, "
           "rig_class TEXT NOT NULL, kind BIGINT NOT NULL, job TEXT NOT NULL, "
           "weight DOUBLE PRECISION NOT NULL, min_ms BIGINT NOT NULL, want_ms BIGINT NOT NULL, "
           "created_ms BIGINT NOT NULL, state BIGINT NOT NULL, offered BIGINT NOT NULL, "
           "offers_missed BIGINT NOT NULL, place BIGINT NOT NULL, expected_ms BIGINT NOT NULL, "
           "first_expected_ms BIGINT NOT NULL)",
           "CREATE UNIQUE INDEX one_live_ticket ON lab_ticket (user_id, rig_class) "
           "WHERE kind = 0 AND state < 2",
           "CREATE TABLE lab_booking (id BIGINT PRIMARY KEY, user_id BIGINT NOT NULL, "
           "rig_class TEXT NOT NULL, start_ms BIGINT NOT NULL, end_ms BIGINT NOT NULL, "
           "state BIGINT NOT NULL, rig TEXT NOT NULL, session BIGINT NOT NULL, "
           "version BIGINT NOT NULL, note TEXT NOT NULL)",
           "CREATE TABLE lab_session (id BIGINT PRIMARY KEY, user_id BIGINT NOT NULL, "
           "rig TEXT NOT NULL, rig_class TEXT NOT NULL, epoch BIGINT NOT NULL, "
           "booking BIGINT NOT NULL, ticket BIGINT NOT NULL, kind BIGINT NOT NULL, "
           "state BIGINT NOT NULL, start_ms BIGINT NOT NULL, hard_end_ms BIGINT NOT NULL, "
           "claim_until_ms BIGINT NOT NULL, last_control_ms BIGINT NOT NULL, "
           "charged_from_ms BIGINT NOT NULL, run_in_progress BIGINT NOT NULL, "
           "warning_stage BIGINT NOT NULL, idle_answer_ms BIGINT NOT NULL, "
           "offered_to BIGINT NOT NULL, end_reason BIGINT NOT NULL, end_text TEXT NOT NULL)",
           "CREATE UNIQUE INDEX one_live_session ON lab_session (rig) WHERE state < 2",
           "CREATE TABLE lab_usage (user_id BIGINT PRIMARY KEY, seconds DOUBLE PRECISION NOT NULL, "
           "at_ms BIGINT NOT NULL)",
           "CREATE TABLE lab_event (seq $ID, user_id BIGINT NOT NULL, at_ms BIGINT NOT NULL, "
           "topic TEXT NOT NULL, text TEXT NOT NULL, session BIGINT NOT NULL)",
           "CREATE INDEX lab_event_by_user ON lab_event (user_id, seq)"},
      .sqlite_statements =
          {"CREATE TRIGGER booking_overlap_1 BEFORE INSERT ON lab_booking "
           "WHEN NEW.state = 0 AND NEW.rig <> '' AND EXISTS (SELECT 1 FROM lab_booking b "
           "WHERE b.rig = NEW.rig AND b.state = 0 AND b.id <> NEW.id "
           "AND b.start_ms < NEW.end_ms AND NEW.start_ms < b.end_ms) "
           "BEGIN SELECT RAISE(ABORT, 'two bookings on one rig'); END",
           "CREATE TRIGGER booking_overlap_2 BEFORE UPDATE ON lab_booking "
           "WHEN NEW.state = 0 AND NEW.rig <> '' AND EXISTS (SELECT 1 FROM lab_booking b "
           "WHERE b.rig = NEW.rig AND b.state = 0 AND b.id <> NEW.id "
           "AND b.start_ms < NEW.end_ms AND NEW.start_ms < b.end_ms) "
           "BEGIN SELECT RAISE(ABORT, 'two bookings on one rig'); END"},
      .postgres_statements = {
          "CREATE EXTENSION IF NOT EXISTS btree_gist",
          "ALTER TABLE lab_booking ADD CONSTRAINT booking_overlap EXCLUDE USING gist "
          "(rig WITH =, int8range(start_ms, end_ms) WITH &&) WHERE (state = 0 AND rig <> '')"}};
}

Migration JobsAndFaultSets() {
  return {
      .version = 4,
      .description = "jobs, fault sets, remembered answers",
      .statements =
          {"CREATE TABLE job (id TEXT PRIMARY KEY, owner TEXT NOT NULL, account_id BIGINT NOT "
           "NULL, "
           "batch TEXT NOT NULL, name TEXT NOT NULL, body TEXT NOT NULL, state TEXT NOT NULL, "
           "run_id TEXT NOT NULL, error TEXT NOT NULL, created_ms BIGINT NOT NULL, "
           "started_ms BIGINT NOT NULL, ended_ms BIGINT NOT NULL, server_id TEXT NOT NULL, "
           "lease_until_ms BIGINT NOT NULL, attempts BIGINT NOT NULL)",
           "CREATE INDEX job_waiting ON job (state, created_ms, id)",
           "CREATE INDEX job_by_owner ON job (owner, created_ms, id)",
           "CREATE TABLE fault_set (id $ID, course_id BIGINT NOT NULL, "
           "account_id BIGINT NOT NULL, name TEXT NOT NULL, version BIGINT NOT NULL, "
           "visible BIGINT NOT NULL, faults TEXT NOT NULL, used BIGINT NOT NULL, "
           "deleted BIGINT NOT NULL, replaces BIGINT NOT NULL, created_ms BIGINT NOT NULL)",
           "CREATE TABLE remembered_answer (owner TEXT NOT NULL, idempotency_key TEXT NOT NULL, "
           "request_hash TEXT NOT NULL, status BIGINT NOT NULL, body TEXT NOT NULL, "
           "at_ms BIGINT NOT NULL, PRIMARY KEY (owner, idempotency_key))"},
      .sqlite_statements = {},
      .postgres_statements = {}};
}

Migration LinksBandsAndEnds() {
  return {.version = 5,
          .description = "jobs in sessions, ends of courses, calendar links, bands of rigs",
          .statements =
              {"ALTER TABLE lab_session ADD COLUMN job TEXT NOT NULL DEFAULT ''",
               "ALTER TABLE job ADD COLUMN result TEXT NOT NULL DEFAULT ''",
               "ALTER TABLE course ADD COLUMN ends_ms BIGINT NOT NULL DEFAULT 0",
               "CREATE TABLE calendar_link (account_id BIGINT PRIMARY KEY REFERENCES account (id), "
               "token_hash TEXT NOT NULL UNIQUE, created_ms BIGINT NOT NULL)",
               "CREATE TABLE rig_band (rig TEXT PRIMARY KEY, b0d DOUBLE PRECISION NOT NULL, "
               "gain DOUBLE PRECISION NOT NULL, a1d DOUBLE PRECISION NOT NULL, "
               "source TEXT NOT NULL, at_ms BIGINT NOT NULL)"},
          .sqlite_statements = {},
          .postgres_statements = {}};
}

Migration RigCalibrationTable() {
  return {.version = 6,
          .description = "calibrations of rigs",
          .statements = {"CREATE TABLE rig_calibration (run TEXT PRIMARY KEY, rig TEXT NOT NULL, "
                         "at_ms BIGINT NOT NULL, body TEXT NOT NULL)",
                         "CREATE INDEX rig_calibration_by_rig ON rig_calibration (rig, at_ms)"},
          .sqlite_statements = {},
          .postgres_statements = {}};
}

Migration CourseInvitations() {
  return {.version = 7,
          .description = "invitations to courses",
          .statements = {"CREATE TABLE course_invitation ("
                         "course_id BIGINT NOT NULL REFERENCES course (id), "
                         "account_id BIGINT NOT NULL REFERENCES account (id), "
                         "invited_by BIGINT NOT NULL REFERENCES account (id), "
                         "created_ms BIGINT NOT NULL, PRIMARY KEY (course_id, account_id))",
                         "CREATE INDEX course_invitation_by_account "
                         "ON course_invitation (account_id)"},
          .sqlite_statements = {},
          .postgres_statements = {}};
}

Migration Members() {
  return {.version = 8,
          .description = "servers as members, and which of them has a rig",
          .statements = {"CREATE TABLE lab_member (id TEXT PRIMARY KEY, boot TEXT NOT NULL, "
                         "address TEXT NOT NULL, lease_until_ms BIGINT NOT NULL)",
                         "ALTER TABLE lab_rig ADD COLUMN server TEXT NOT NULL DEFAULT ''"},
          .sqlite_statements = {},
          .postgres_statements = {}};
}

Migration DiagnosisOptionsOfRuns() {
  return {.version = 9,
          .description = "options of a recording's diagnosis",
          .statements = {"ALTER TABLE recording ADD COLUMN options_json TEXT NOT NULL DEFAULT ''"},
          .sqlite_statements = {},
          .postgres_statements = {}};
}

Migration DevicesAndIdentities() {
  return {.version = 10,
          .description = "devices that signed in before, identities at sign-in providers",
          .statements =
              {"CREATE TABLE known_device (token_hash TEXT NOT NULL, "
               "account_id BIGINT NOT NULL REFERENCES account (id), created_ms BIGINT NOT NULL, "
               "used_ms BIGINT NOT NULL, PRIMARY KEY (token_hash, account_id))",
               "CREATE INDEX known_device_by_account ON known_device (account_id, used_ms)",
               "CREATE TABLE external_identity (issuer TEXT NOT NULL, subject TEXT NOT NULL, "
               "account_id BIGINT NOT NULL REFERENCES account (id), added BIGINT NOT NULL, "
               "created_ms BIGINT NOT NULL, PRIMARY KEY (issuer, subject))",
               "CREATE INDEX external_identity_by_account ON external_identity (account_id)",
               "CREATE TABLE used_login (state_hash TEXT PRIMARY KEY, expires_ms BIGINT NOT NULL)"},
          .sqlite_statements = {},
          .postgres_statements = {}};
}

/// Names that anybody had sent on the bus were stored as rigs; this removes those that were never
/// checked and never given to anybody.
Migration ForgottenRigNames() {
  return {.version = 11,
          .description = "names on the bus that were never rigs",
          .statements = {"DELETE FROM lab_rig WHERE epoch = 0 AND server = '' "
                         "AND id NOT IN (SELECT rig FROM lab_outage)"},
          .sqlite_statements = {},
          .postgres_statements = {}};
}

/// A teacher sees what a student has made since joining.
Migration EnrolledSince() {
  return {.version = 12,
          .description = "since when somebody is enrolled",
          .statements = {"ALTER TABLE enrolment ADD COLUMN since_ms BIGINT NOT NULL DEFAULT 0"},
          .sqlite_statements = {},
          .postgres_statements = {}};
}

/// The columns that lists show of a job are stored beside its body, which is deleted when the job
/// has ended.
Migration BoundedRows() {
  // PostgreSQL cannot parse JSON that contains a zero byte.
  const std::string fill =
      "UPDATE job SET run_name = COALESCE($NAME, ''), rig = COALESCE($RIG, ''), "
      "recording = COALESCE($RECORDING, '') WHERE body LIKE '{%' AND body NOT LIKE '%\\\\u0000%'";
  const std::string clear =
      "UPDATE job SET body = '', body_bytes = 0 WHERE state IN ('finished', 'failed', 'cancelled')";
  const auto filled = [&fill](const std::vector<std::pair<std::string, std::string>>& words) {
    std::string text = fill;
    for (const auto& [word, by] : words) text.replace(text.find(word), word.size(), by);
    return text;
  };
  return {
      .version = 13,
      .description = "jobs without their bodies in lists, indexes for what has a limit",
      .statements = {"ALTER TABLE job ADD COLUMN run_name TEXT NOT NULL DEFAULT ''",
                     "ALTER TABLE job ADD COLUMN rig TEXT NOT NULL DEFAULT ''",
                     "ALTER TABLE job ADD COLUMN recording TEXT NOT NULL DEFAULT ''",
                     "ALTER TABLE job ADD COLUMN body_bytes BIGINT NOT NULL DEFAULT 0",
                     "ALTER TABLE one_time_link ADD COLUMN made_by TEXT NOT NULL DEFAULT ''",
                     "CREATE INDEX api_key_by_account ON api_key (account_id, id)",
                     "CREATE INDEX enrolment_by_account ON enrolment (account_id, course_id)",
                     "CREATE INDEX fault_set_by_author ON fault_set (account_id, id)",
                     "CREATE INDEX fault_set_by_course ON fault_set (course_id, id)",
                     "CREATE INDEX job_of_owner_by_state ON job (owner, state, ended_ms)",
                     "CREATE INDEX remembered_answer_by_time ON remembered_answer (at_ms)"},
      .sqlite_statements = {filled({{"$NAME", "json_extract(body, '$.name')"},
                                    {"$RIG", "json_extract(body, '$.rig')"},
                                    {"$RECORDING", "json_extract(body, '$.diagnose.recording')"}}),
                            "UPDATE job SET body_bytes = LENGTH(CAST(body AS BLOB))",
                            clear},
      .postgres_statements = {
          filled({{"$NAME", "CAST(body AS json) ->> 'name'"},
                  {"$RIG", "CAST(body AS json) ->> 'rig'"},
                  {"$RECORDING", "CAST(body AS json) -> 'diagnose' ->> 'recording'"}}),
          "UPDATE job SET body_bytes = octet_length(body)",
          clear}};
}

/// The calibration from a run with hidden faults revealed their values.
Migration CalibrationsOfHiddenFaults() {
  return {.version = 14,
          .description = "calibrations that hidden faults were in",
          .statements = {"DELETE FROM rig_calibration WHERE run IN (SELECT id FROM recording "
                         "WHERE plan_json LIKE '%\"hidden_faults\":true%')"},
          .sqlite_statements = {},
          .postgres_statements = {}};
}

/// Accounts made by a class list, with the owner of that list (0 = an admin or the person).
Migration AccountsOfClassLists() {
  return {.version = 15,
          .description = "who made an account by a class list",
          .statements = {"ALTER TABLE account ADD COLUMN made_by BIGINT NOT NULL DEFAULT 0",
                         "CREATE INDEX account_by_maker ON account (made_by)"},
          .sqlite_statements = {},
          .postgres_statements = {}};
}

/// What rigs are built like, and by which description each recording is read. '' stands for the
/// paper's bench, which older programs knew alone.
Migration BenchDescriptions() {
  return {.version = 16,
          .description = "descriptions of benches",
          .statements = {"CREATE TABLE bench (id TEXT PRIMARY KEY, text TEXT NOT NULL, "
                         "since_ms BIGINT NOT NULL)",
                         "CREATE TABLE rig_bench (rig TEXT PRIMARY KEY, bench TEXT NOT NULL)",
                         "ALTER TABLE recording ADD COLUMN bench TEXT NOT NULL DEFAULT ''",
                         "ALTER TABLE rig_calibration ADD COLUMN bench TEXT NOT NULL DEFAULT ''",
                         "ALTER TABLE fault_set ADD COLUMN bench TEXT NOT NULL DEFAULT 'paper'"},
          .sqlite_statements = {},
          .postgres_statements = {}};
}

/// Pictures of the bench during a run; their bytes are in blob_store.
Migration RecordingPictures() {
  return {.version = 17,
          .description = "pictures of recordings",
          .statements = {"CREATE TABLE recording_picture ("
                         "recording_id TEXT NOT NULL REFERENCES recording (id) ON DELETE CASCADE, "
                         "picture BIGINT NOT NULL, sample_index BIGINT NOT NULL, "
                         "why TEXT NOT NULL, content_type TEXT NOT NULL, "
                         "size_bytes BIGINT NOT NULL, PRIMARY KEY (recording_id, picture))"},
          .sqlite_statements = {},
          .postgres_statements = {}};
}

/// The name by which a far rig keeps the run: what a server that was killed has not written is read
/// again from there.
Migration RunsKeptByTheRig() {
  return {.version = 18,
          .description = "runs that their rigs keep",
          .statements = {"ALTER TABLE recording ADD COLUMN kept_run TEXT NOT NULL DEFAULT ''"},
          .sqlite_statements = {},
          .postgres_statements = {}};
}

/// Stars are of the person by whose key recordings are owned, "user:7".
Migration NotesAndStars() {
  return {.version = 19,
          .description = "notes and stars of recordings",
          .statements = {"ALTER TABLE recording ADD COLUMN note TEXT NOT NULL DEFAULT ''",
                         "CREATE TABLE recording_star ("
                         "recording_id TEXT NOT NULL REFERENCES recording (id) ON DELETE CASCADE, "
                         "who TEXT NOT NULL, PRIMARY KEY (recording_id, who))",
                         "CREATE INDEX recording_star_by_person ON recording_star (who)"},
          .sqlite_statements = {},
          .postgres_statements = {}};
}

/// What a message is about, as values: the page makes its own sentence of them.
Migration FactsOfMessages() {
  return {.version = 20,
          .description = "rig, other person and reason of messages to users",
          .statements = {"ALTER TABLE lab_event ADD COLUMN rig TEXT NOT NULL DEFAULT ''",
                         "ALTER TABLE lab_event ADD COLUMN other_id BIGINT NOT NULL DEFAULT 0",
                         "ALTER TABLE lab_event ADD COLUMN why TEXT NOT NULL DEFAULT ''"},
          .sqlite_statements = {},
          .postgres_statements = {}};
}

/// What operators look at: the steps of checks, what each rig was used for, how often its relays
/// have closed, and alarms. `acked_by` is the account, 0 while nobody has acknowledged.
Migration OperationOfRigs() {
  return {.version = 21,
          .description = "checks, use, relay cycles and alarms of rigs",
          .statements =
              {"CREATE TABLE rig_check (id $ID, rig TEXT NOT NULL, at_ms BIGINT NOT NULL, "
               "kind TEXT NOT NULL, passed BIGINT NOT NULL, reason TEXT NOT NULL)",
               "CREATE INDEX rig_check_by_rig ON rig_check (rig, id)",
               "CREATE TABLE rig_check_step (check_id BIGINT NOT NULL, place BIGINT NOT NULL, "
               "step TEXT NOT NULL, subject TEXT NOT NULL, passed BIGINT NOT NULL, "
               "has_figure BIGINT NOT NULL, measured DOUBLE PRECISION NOT NULL, "
               "low DOUBLE PRECISION NOT NULL, high DOUBLE PRECISION NOT NULL, unit TEXT NOT NULL, "
               "text TEXT NOT NULL, PRIMARY KEY (check_id, place))",
               "CREATE TABLE rig_use (rig TEXT NOT NULL, at_ms BIGINT NOT NULL, "
               "what TEXT NOT NULL, PRIMARY KEY (rig, at_ms))",
               "CREATE TABLE relay_cycles (rig TEXT NOT NULL, line BIGINT NOT NULL, "
               "cycles BIGINT NOT NULL, since_ms BIGINT NOT NULL, PRIMARY KEY (rig, line))",
               "CREATE TABLE alarm (id $ID, kind TEXT NOT NULL, subject TEXT NOT NULL, "
               "text TEXT NOT NULL, at_ms BIGINT NOT NULL, last_ms BIGINT NOT NULL, "
               "times BIGINT NOT NULL, ended_ms BIGINT NOT NULL, acked_ms BIGINT NOT NULL, "
               "acked_by BIGINT NOT NULL)",
               "CREATE UNIQUE INDEX one_open_alarm ON alarm (kind, subject) WHERE ended_ms = 0"},
          .sqlite_statements = {},
          .postgres_statements = {}};
}

/// Why the lab did something as a word, and the time that a message is about. Whose bookings an
/// outage has cancelled. A failed check is known by a column, not by its text.
Migration ReasonsOfMessages() {
  return {
      .version = 22,
      .description = "reason and time of messages, cancelled bookings of outages, failed checks",
      .statements = {"ALTER TABLE lab_event ADD COLUMN reason TEXT NOT NULL DEFAULT ''",
                     "ALTER TABLE lab_event ADD COLUMN time_ms BIGINT NOT NULL DEFAULT 0",
                     "ALTER TABLE lab_outage ADD COLUMN fallen TEXT NOT NULL DEFAULT ''",
                     "ALTER TABLE lab_rig ADD COLUMN check_failed BIGINT NOT NULL DEFAULT 0",
                     "UPDATE lab_rig SET check_failed = 1 WHERE status = 4 "
                     "AND reason LIKE 'the check between users failed: %'"},
      .sqlite_statements = {},
      .postgres_statements = {}};
}

/// A claim of a job lasts as long as its server's membership, so it needs no lease of its own.
/// Indexes: whose turn it is on which rig, and the jobs of a batch.
Migration FencedJobs() {
  return {.version = 23,
          .description = "jobs are claimed by a membership",
          .statements = {"ALTER TABLE job ADD COLUMN boot TEXT NOT NULL DEFAULT ''",
                         "ALTER TABLE job DROP COLUMN lease_until_ms",
                         "DROP INDEX job_waiting",
                         "CREATE INDEX job_in_turn ON job (state, rig, owner, created_ms, id)",
                         "CREATE INDEX job_by_batch ON job (batch, created_ms, id)"},
          .sqlite_statements = {},
          .postgres_statements = {}};
}

/// Messages to other programs and by mail. `channel` is "hook:3" or "mail", `account_id` the person
/// whom a message is about (by mail: to whom it goes). The cursor is how far the lab's own messages
/// have been read; `told` is the same of alarms. What happened before this step is told nobody.
Migration Outbox() {
  return {.version = 24,
          .description = "webhooks, mail and their outbox",
          .statements =
              {"CREATE TABLE webhook (id $ID, url TEXT NOT NULL, secret TEXT NOT NULL, "
               "kinds TEXT NOT NULL, created_ms BIGINT NOT NULL, delivered_ms BIGINT NOT NULL, "
               "failed_ms BIGINT NOT NULL, error TEXT NOT NULL)",
               "CREATE TABLE mail_choice (account_id BIGINT PRIMARY KEY REFERENCES account (id), "
               "address TEXT NOT NULL, language TEXT NOT NULL, kinds TEXT NOT NULL, "
               "asked_ms BIGINT NOT NULL, verified_ms BIGINT NOT NULL)",
               "CREATE TABLE outbox (id $ID, delivery TEXT NOT NULL UNIQUE, "
               "channel TEXT NOT NULL, account_id BIGINT NOT NULL, kind TEXT NOT NULL, "
               "about TEXT NOT NULL, created_ms BIGINT NOT NULL, state TEXT NOT NULL, "
               "attempts BIGINT NOT NULL, next_ms BIGINT NOT NULL, ended_ms BIGINT NOT NULL, "
               "error TEXT NOT NULL, member TEXT NOT NULL, boot TEXT NOT NULL)",
               "CREATE INDEX outbox_due ON outbox (state, next_ms, id)",
               "CREATE INDEX outbox_by_channel ON outbox (channel, state, id)",
               "CREATE TABLE outbox_cursor (id BIGINT PRIMARY KEY, event_seq BIGINT NOT NULL, "
               "reminded_ms BIGINT NOT NULL)",
               "INSERT INTO outbox_cursor (id, event_seq, reminded_ms) "
               "SELECT 1, COALESCE(MAX(seq), 0), 0 FROM lab_event",
               "ALTER TABLE alarm ADD COLUMN told BIGINT NOT NULL DEFAULT 0",
               "UPDATE alarm SET told = 1"},
          .sqlite_statements = {},
          .postgres_statements = {}};
}

/// What an admin has changed of the lab's policy, and what it needs to be kept: how far a session
/// was extended, and the use of a person in the present week.
Migration LabPolicy() {
  return {.version = 25,
          .description = "policy of the lab",
          .statements = {"CREATE TABLE lab_policy (name TEXT PRIMARY KEY, value BIGINT NOT NULL)",
                         "ALTER TABLE lab_session ADD COLUMN extended_ms BIGINT NOT NULL DEFAULT 0",
                         "ALTER TABLE lab_usage ADD COLUMN week BIGINT NOT NULL DEFAULT 0",
                         "ALTER TABLE lab_usage ADD COLUMN this_week_ms BIGINT NOT NULL DEFAULT 0"},
          .sqlite_statements = {},
          .postgres_statements = {}};
}

/// How the input moved while a calibration was learnt, and why no run may start with it.
Migration OriginsOfCalibrations() {
  return {.version = 26,
          .description = "origins of calibrations",
          .statements = {"ALTER TABLE rig_calibration ADD COLUMN unfit TEXT NOT NULL DEFAULT "
                         "'learnt by an earlier program'",
                         "ALTER TABLE rig_calibration ADD COLUMN low_v DOUBLE PRECISION NOT NULL "
                         "DEFAULT 0",
                         "ALTER TABLE rig_calibration ADD COLUMN high_v DOUBLE PRECISION NOT NULL "
                         "DEFAULT 0",
                         "ALTER TABLE rig_calibration ADD COLUMN rms_v DOUBLE PRECISION NOT NULL "
                         "DEFAULT 0"},
          .sqlite_statements = {},
          .postgres_statements = {}};
}

/// Assignments of courses and the blind trials of their students; 0 is a time that has not come.
Migration BlindTrials() {
  return {.version = 27,
          .description = "blind trials",
          .statements = {"ALTER TABLE fault_set ADD COLUMN pool TEXT NOT NULL DEFAULT ''",
                         "CREATE TABLE assignment (id $ID, course_id BIGINT NOT NULL, "
                         "account_id BIGINT NOT NULL, fault_set_id BIGINT NOT NULL, "
                         "name TEXT NOT NULL, bench TEXT NOT NULL, pool TEXT NOT NULL, "
                         "plan TEXT NOT NULL, rubric TEXT NOT NULL, opens_ms BIGINT NOT NULL, "
                         "due_ms BIGINT NOT NULL, attempts BIGINT NOT NULL, "
                         "reveal_at_once BIGINT NOT NULL, secret TEXT NOT NULL, "
                         "created_ms BIGINT NOT NULL, deleted BIGINT NOT NULL)",
                         "CREATE INDEX assignment_by_course ON assignment (course_id, id)",
                         "CREATE TABLE trial (id $ID, assignment_id BIGINT NOT NULL, "
                         "account_id BIGINT NOT NULL, state TEXT NOT NULL, item BIGINT NOT NULL, "
                         "run TEXT NOT NULL, commitment TEXT NOT NULL, nonce TEXT NOT NULL, "
                         "truth TEXT NOT NULL, events TEXT NOT NULL, created_ms BIGINT NOT NULL, "
                         "ended_ms BIGINT NOT NULL, answer TEXT NOT NULL, "
                         "answered_ms BIGINT NOT NULL, grade TEXT NOT NULL, "
                         "released_ms BIGINT NOT NULL, why TEXT NOT NULL)",
                         "CREATE INDEX trial_by_person ON trial (assignment_id, account_id, id)",
                         "CREATE INDEX trial_by_account ON trial (account_id, id)"},
          .sqlite_statements = {},
          .postgres_statements = {}};
}

/// Assignments that change, longer times for single students, and points given by a teacher.
Migration ChangedAssignments() {
  return {.version = 28,
          .description = "changes of assignments",
          .statements = {"ALTER TABLE assignment ADD COLUMN version BIGINT NOT NULL DEFAULT 1",
                         "CREATE TABLE assignment_extension (assignment_id BIGINT NOT NULL, "
                         "account_id BIGINT NOT NULL, due_ms BIGINT NOT NULL, "
                         "PRIMARY KEY (assignment_id, account_id))",
                         "ALTER TABLE trial ADD COLUMN awarded TEXT NOT NULL DEFAULT ''"},
          .sqlite_statements = {},
          .postgres_statements = {}};
}

/// Assignments whose trials run on the lab's benches.
Migration TrialsOnBenches() {
  return {.version = 29,
          .description = "trials on benches",
          .statements = {"ALTER TABLE assignment ADD COLUMN on_bench BIGINT NOT NULL DEFAULT 0"},
          .sqlite_statements = {},
          .postgres_statements = {}};
}

/// Rubrics that change, by the newest of which answers are graded again, and students who share
/// their trials.
Migration RubricsAndGroups() {
  return {
      .version = 30,
      .description = "changes of rubrics, groups",
      .statements = {"ALTER TABLE assignment ADD COLUMN rubric_version BIGINT NOT NULL DEFAULT 1",
                     "ALTER TABLE trial ADD COLUMN graded_by BIGINT NOT NULL DEFAULT 1",
                     "ALTER TABLE assignment ADD COLUMN group_max BIGINT NOT NULL DEFAULT 1",
                     "CREATE TABLE assignment_group (id $ID, assignment_id BIGINT NOT NULL, "
                     "code TEXT NOT NULL)",
                     "CREATE UNIQUE INDEX assignment_group_by_code ON assignment_group "
                     "(assignment_id, code)",
                     "CREATE TABLE assignment_mate (assignment_id BIGINT NOT NULL, "
                     "account_id BIGINT NOT NULL, group_id BIGINT NOT NULL, "
                     "PRIMARY KEY (assignment_id, account_id))",
                     "CREATE INDEX assignment_mate_by_group ON assignment_mate (group_id)"},
      .sqlite_statements = {},
      .postgres_statements = {}};
}

/// Whose turn it is: among the jobs that run something on which rig, and among those that compute.
Migration JobsInTurn() {
  return {.version = 31,
          .description = "turns of jobs, networks of devices, uploads that were cut",
          .statements = {"DROP INDEX job_in_turn",
                         "CREATE INDEX job_to_run ON job (rig, owner, created_ms, id) "
                         "WHERE state = 'waiting' AND recording = ''",
                         "CREATE INDEX job_to_compute ON job (rig, owner, created_ms, id) "
                         "WHERE state = 'waiting' AND recording <> ''",
                         "CREATE INDEX job_running ON job (owner) WHERE state = 'running'",
                         "ALTER TABLE known_device ADD COLUMN network TEXT NOT NULL DEFAULT ''",
                         // Uploads that a crash has cut: no server could end them.
                         "UPDATE recording SET state = 'interrupted', ended_ms = created_ms "
                         "WHERE state = 'running' AND source = 'upload' AND server_id = ''"},
          .sqlite_statements = {},
          .postgres_statements = {}};
}

/// Who brought a record of a trial that was not released.
Migration CopiesOfTrials() {
  return {
      .version = 32,
      .description = "copies of sealed records",
      .statements = {"ALTER TABLE trial ADD COLUMN copies TEXT NOT NULL DEFAULT '[]'",
                     "CREATE INDEX trial_sealed ON trial (assignment_id) WHERE released_ms = 0"},
      .sqlite_statements = {},
      .postgres_statements = {}};
}

}  // namespace

const std::vector<Migration>& AllMigrations() {
  static const std::vector<Migration> kAll = {Recordings(),
                                              Accounts(),
                                              Lab(),
                                              JobsAndFaultSets(),
                                              LinksBandsAndEnds(),
                                              RigCalibrationTable(),
                                              CourseInvitations(),
                                              Members(),
                                              DiagnosisOptionsOfRuns(),
                                              DevicesAndIdentities(),
                                              ForgottenRigNames(),
                                              EnrolledSince(),
                                              BoundedRows(),
                                              CalibrationsOfHiddenFaults(),
                                              AccountsOfClassLists(),
                                              BenchDescriptions(),
                                              RecordingPictures(),
                                              RunsKeptByTheRig(),
                                              NotesAndStars(),
                                              FactsOfMessages(),
                                              OperationOfRigs(),
                                              ReasonsOfMessages(),
                                              FencedJobs(),
                                              Outbox(),
                                              LabPolicy(),
                                              OriginsOfCalibrations(),
                                              BlindTrials(),
                                              ChangedAssignments(),
                                              TrialsOnBenches(),
                                              RubricsAndGroups(),
                                              JobsInTurn(),
                                              CopiesOfTrials()};
  return kAll;
}

}  // namespace faultlab::server

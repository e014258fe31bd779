-- The schema of both engines, one statement a paragraph. $ID is an auto-numbered key, $BLOB is bytes.
-- A statement behind "sqlite:" or "postgresql:" is of that engine alone. From 1.0.0 on this file never
-- changes: a change is a step in schema.cc.

CREATE TABLE recording (
  id TEXT PRIMARY KEY, name TEXT NOT NULL, owner TEXT NOT NULL, rig TEXT NOT NULL, source TEXT NOT NULL,
  server_id TEXT NOT NULL, epoch BIGINT NOT NULL, period_s DOUBLE PRECISION NOT NULL, plan_json TEXT NOT NULL,
  state TEXT NOT NULL, created_ms BIGINT NOT NULL, ended_ms BIGINT, samples BIGINT NOT NULL,
  next_index BIGINT NOT NULL, diagnosis_json TEXT NOT NULL, verdict TEXT NOT NULL,
  options_json TEXT NOT NULL DEFAULT '', bench TEXT NOT NULL DEFAULT '', kept_run TEXT NOT NULL DEFAULT '',
  note TEXT NOT NULL DEFAULT '');

CREATE INDEX recording_by_time ON recording (created_ms, id);

CREATE INDEX recording_by_owner ON recording (owner, created_ms, id);

CREATE TABLE recording_event (
  recording_id TEXT NOT NULL REFERENCES recording (id) ON DELETE CASCADE, seq BIGINT NOT NULL,
  sample_index BIGINT NOT NULL, kind TEXT NOT NULL, json TEXT NOT NULL, PRIMARY KEY (recording_id, seq));

CREATE TABLE blob_store (
  owner TEXT NOT NULL, seq BIGINT NOT NULL, bytes $BLOB NOT NULL, PRIMARY KEY (owner, seq));

CREATE TABLE account (
  id $ID, login TEXT NOT NULL UNIQUE, name TEXT NOT NULL, role TEXT NOT NULL, password_hash TEXT NOT NULL,
  disabled BIGINT NOT NULL, created_ms BIGINT NOT NULL, version BIGINT NOT NULL,
  made_by BIGINT NOT NULL DEFAULT 0);

CREATE INDEX account_by_maker ON account (made_by);

CREATE TABLE sign_in (
  token_hash TEXT PRIMARY KEY, account_id BIGINT NOT NULL REFERENCES account (id), csrf TEXT NOT NULL,
  created_ms BIGINT NOT NULL, expires_ms BIGINT NOT NULL, address TEXT NOT NULL);

CREATE TABLE api_key (
  id $ID, account_id BIGINT NOT NULL REFERENCES account (id), name TEXT NOT NULL,
  key_hash TEXT NOT NULL UNIQUE, scopes TEXT NOT NULL, created_ms BIGINT NOT NULL, expires_ms BIGINT NOT NULL,
  revoked BIGINT NOT NULL);

CREATE INDEX api_key_by_account ON api_key (account_id, id);

CREATE TABLE one_time_link (
  token_hash TEXT PRIMARY KEY, account_id BIGINT NOT NULL REFERENCES account (id), expires_ms BIGINT NOT NULL,
  used BIGINT NOT NULL, made_by TEXT NOT NULL DEFAULT '');

CREATE TABLE course (
  id $ID, name TEXT NOT NULL, created_ms BIGINT NOT NULL, ends_ms BIGINT NOT NULL DEFAULT 0);

CREATE TABLE enrolment (
  course_id BIGINT NOT NULL REFERENCES course (id), account_id BIGINT NOT NULL REFERENCES account (id),
  teaches BIGINT NOT NULL, since_ms BIGINT NOT NULL DEFAULT 0, PRIMARY KEY (course_id, account_id));

CREATE INDEX enrolment_by_account ON enrolment (account_id, course_id);

CREATE TABLE audit_log (
  seq $ID, at_ms BIGINT NOT NULL, actor TEXT NOT NULL, verb TEXT NOT NULL, object TEXT NOT NULL,
  detail TEXT NOT NULL);

sqlite: CREATE TRIGGER audit_log_is_append_only_1 BEFORE UPDATE ON audit_log
  BEGIN SELECT RAISE(ABORT, 'the audit log is append-only'); END;

sqlite: CREATE TRIGGER audit_log_is_append_only_2 BEFORE DELETE ON audit_log
  BEGIN SELECT RAISE(ABORT, 'the audit log is append-only'); END;

postgresql: CREATE FUNCTION refuse_change() RETURNS trigger LANGUAGE plpgsql AS
  $body$ BEGIN RAISE EXCEPTION 'the audit log is append-only'; END $body$;

postgresql: CREATE TRIGGER audit_log_is_append_only BEFORE UPDATE OR DELETE ON audit_log
  FOR EACH ROW EXECUTE FUNCTION refuse_change();

CREATE TABLE lab_meta (
  id BIGINT PRIMARY KEY, version BIGINT NOT NULL, next_id BIGINT NOT NULL);

INSERT INTO lab_meta (id, version, next_id) VALUES (1, 0, 1);

CREATE TABLE lab_rig (
  id TEXT PRIMARY KEY, rig_class TEXT NOT NULL, elastic BIGINT NOT NULL, status BIGINT NOT NULL,
  epoch BIGINT NOT NULL, cleaning_due_ms BIGINT NOT NULL, wear_ms BIGINT NOT NULL, reason TEXT NOT NULL,
  server TEXT NOT NULL DEFAULT '', check_failed BIGINT NOT NULL DEFAULT 0);

CREATE TABLE lab_outage (
  id BIGINT PRIMARY KEY, rig TEXT NOT NULL, start_ms BIGINT NOT NULL, end_ms BIGINT NOT NULL,
  reason TEXT NOT NULL, fallen TEXT NOT NULL DEFAULT '');

CREATE TABLE lab_ticket (
  id BIGINT PRIMARY KEY, user_id BIGINT NOT NULL, rig_class TEXT NOT NULL, kind BIGINT NOT NULL,
  job TEXT NOT NULL, weight DOUBLE PRECISION NOT NULL, min_ms BIGINT NOT NULL, want_ms BIGINT NOT NULL,
  created_ms BIGINT NOT NULL, state BIGINT NOT NULL, offered BIGINT NOT NULL, offers_missed BIGINT NOT NULL,
  place BIGINT NOT NULL, expected_ms BIGINT NOT NULL, first_expected_ms BIGINT NOT NULL);

CREATE UNIQUE INDEX one_live_ticket ON lab_ticket (user_id, rig_class) WHERE kind = 0 AND state < 2;

CREATE TABLE lab_booking (
  id BIGINT PRIMARY KEY, user_id BIGINT NOT NULL, rig_class TEXT NOT NULL, start_ms BIGINT NOT NULL,
  end_ms BIGINT NOT NULL, state BIGINT NOT NULL, rig TEXT NOT NULL, session BIGINT NOT NULL,
  version BIGINT NOT NULL, note TEXT NOT NULL);

sqlite: CREATE TRIGGER booking_overlap_1 BEFORE INSERT ON lab_booking
  WHEN NEW.state = 0 AND NEW.rig <> '' AND EXISTS (SELECT 1 FROM lab_booking b
    WHERE b.rig = NEW.rig AND b.state = 0 AND b.id <> NEW.id AND b.start_ms < NEW.end_ms AND NEW.start_ms < b.end_ms)
  BEGIN SELECT RAISE(ABORT, 'two bookings on one rig'); END;

sqlite: CREATE TRIGGER booking_overlap_2 BEFORE UPDATE ON lab_booking
  WHEN NEW.state = 0 AND NEW.rig <> '' AND EXISTS (SELECT 1 FROM lab_booking b
    WHERE b.rig = NEW.rig AND b.state = 0 AND b.id <> NEW.id AND b.start_ms < NEW.end_ms AND NEW.start_ms < b.end_ms)
  BEGIN SELECT RAISE(ABORT, 'two bookings on one rig'); END;

postgresql: CREATE EXTENSION IF NOT EXISTS btree_gist;

postgresql: ALTER TABLE lab_booking ADD CONSTRAINT booking_overlap EXCLUDE USING gist
  (rig WITH =, int8range(start_ms, end_ms) WITH &&) WHERE (state = 0 AND rig <> '');

CREATE TABLE lab_session (
  id BIGINT PRIMARY KEY, user_id BIGINT NOT NULL, rig TEXT NOT NULL, rig_class TEXT NOT NULL,
  epoch BIGINT NOT NULL, booking BIGINT NOT NULL, ticket BIGINT NOT NULL, kind BIGINT NOT NULL,
  state BIGINT NOT NULL, start_ms BIGINT NOT NULL, hard_end_ms BIGINT NOT NULL, claim_until_ms BIGINT NOT NULL,
  last_control_ms BIGINT NOT NULL, charged_from_ms BIGINT NOT NULL, run_in_progress BIGINT NOT NULL,
  warning_stage BIGINT NOT NULL, idle_answer_ms BIGINT NOT NULL, offered_to BIGINT NOT NULL,
  end_reason BIGINT NOT NULL, end_text TEXT NOT NULL, job TEXT NOT NULL DEFAULT '',
  extended_ms BIGINT NOT NULL DEFAULT 0);

CREATE UNIQUE INDEX one_live_session ON lab_session (rig) WHERE state < 2;

CREATE TABLE lab_usage (
  user_id BIGINT PRIMARY KEY, seconds DOUBLE PRECISION NOT NULL, at_ms BIGINT NOT NULL,
  week BIGINT NOT NULL DEFAULT 0, this_week_ms BIGINT NOT NULL DEFAULT 0);

CREATE TABLE lab_event (
  seq $ID, user_id BIGINT NOT NULL, at_ms BIGINT NOT NULL, topic TEXT NOT NULL, text TEXT NOT NULL,
  session BIGINT NOT NULL, rig TEXT NOT NULL DEFAULT '', other_id BIGINT NOT NULL DEFAULT 0,
  why TEXT NOT NULL DEFAULT '', reason TEXT NOT NULL DEFAULT '', time_ms BIGINT NOT NULL DEFAULT 0);

CREATE INDEX lab_event_by_user ON lab_event (user_id, seq);

CREATE TABLE job (
  id TEXT PRIMARY KEY, owner TEXT NOT NULL, account_id BIGINT NOT NULL, batch TEXT NOT NULL,
  name TEXT NOT NULL, body TEXT NOT NULL, state TEXT NOT NULL, run_id TEXT NOT NULL, error TEXT NOT NULL,
  created_ms BIGINT NOT NULL, started_ms BIGINT NOT NULL, ended_ms BIGINT NOT NULL, server_id TEXT NOT NULL,
  attempts BIGINT NOT NULL, result TEXT NOT NULL DEFAULT '', run_name TEXT NOT NULL DEFAULT '',
  rig TEXT NOT NULL DEFAULT '', recording TEXT NOT NULL DEFAULT '', body_bytes BIGINT NOT NULL DEFAULT 0,
  boot TEXT NOT NULL DEFAULT '');

CREATE INDEX job_by_owner ON job (owner, created_ms, id);

CREATE INDEX job_of_owner_by_state ON job (owner, state, ended_ms);

CREATE INDEX job_by_batch ON job (batch, created_ms, id);

CREATE INDEX job_to_run ON job (rig, owner, created_ms, id) WHERE state = 'waiting' AND recording = '';

CREATE INDEX job_to_compute ON job (rig, owner, created_ms, id) WHERE state = 'waiting' AND recording <> '';

CREATE INDEX job_running ON job (owner) WHERE state = 'running';

CREATE TABLE fault_set (
  id $ID, course_id BIGINT NOT NULL, account_id BIGINT NOT NULL, name TEXT NOT NULL, version BIGINT NOT NULL,
  visible BIGINT NOT NULL, faults TEXT NOT NULL, used BIGINT NOT NULL, deleted BIGINT NOT NULL,
  replaces BIGINT NOT NULL, created_ms BIGINT NOT NULL, bench TEXT NOT NULL DEFAULT 'paper',
  pool TEXT NOT NULL DEFAULT '');

CREATE INDEX fault_set_by_author ON fault_set (account_id, id);

CREATE INDEX fault_set_by_course ON fault_set (course_id, id);

CREATE TABLE remembered_answer (
  owner TEXT NOT NULL, idempotency_key TEXT NOT NULL, request_hash TEXT NOT NULL, status BIGINT NOT NULL,
  body TEXT NOT NULL, at_ms BIGINT NOT NULL, PRIMARY KEY (owner, idempotency_key));

CREATE INDEX remembered_answer_by_time ON remembered_answer (at_ms);

CREATE TABLE calendar_link (
  account_id BIGINT PRIMARY KEY REFERENCES account (id), token_hash TEXT NOT NULL UNIQUE,
  created_ms BIGINT NOT NULL);

CREATE TABLE rig_band (
  rig TEXT PRIMARY KEY, b0d DOUBLE PRECISION NOT NULL, gain DOUBLE PRECISION NOT NULL,
  a1d DOUBLE PRECISION NOT NULL, source TEXT NOT NULL, at_ms BIGINT NOT NULL);

CREATE TABLE rig_calibration (
  run TEXT PRIMARY KEY, rig TEXT NOT NULL, at_ms BIGINT NOT NULL, body TEXT NOT NULL,
  bench TEXT NOT NULL DEFAULT '', unfit TEXT NOT NULL DEFAULT 'learnt by an earlier program',
  low_v DOUBLE PRECISION NOT NULL DEFAULT 0, high_v DOUBLE PRECISION NOT NULL DEFAULT 0,
  rms_v DOUBLE PRECISION NOT NULL DEFAULT 0);

CREATE INDEX rig_calibration_by_rig ON rig_calibration (rig, at_ms);

CREATE TABLE course_invitation (
  course_id BIGINT NOT NULL REFERENCES course (id), account_id BIGINT NOT NULL REFERENCES account (id),
  invited_by BIGINT NOT NULL REFERENCES account (id), created_ms BIGINT NOT NULL,
  PRIMARY KEY (course_id, account_id));

CREATE INDEX course_invitation_by_account ON course_invitation (account_id);

CREATE TABLE lab_member (
  id TEXT PRIMARY KEY, boot TEXT NOT NULL, address TEXT NOT NULL, lease_until_ms BIGINT NOT NULL);

CREATE TABLE known_device (
  token_hash TEXT NOT NULL, account_id BIGINT NOT NULL REFERENCES account (id), created_ms BIGINT NOT NULL,
  used_ms BIGINT NOT NULL, network TEXT NOT NULL DEFAULT '', PRIMARY KEY (token_hash, account_id));

CREATE INDEX known_device_by_account ON known_device (account_id, used_ms);

CREATE TABLE external_identity (
  issuer TEXT NOT NULL, subject TEXT NOT NULL, account_id BIGINT NOT NULL REFERENCES account (id),
  added BIGINT NOT NULL, created_ms BIGINT NOT NULL, PRIMARY KEY (issuer, subject));

CREATE INDEX external_identity_by_account ON external_identity (account_id);

CREATE TABLE used_login (
  state_hash TEXT PRIMARY KEY, expires_ms BIGINT NOT NULL);

CREATE TABLE bench (
  id TEXT PRIMARY KEY, text TEXT NOT NULL, since_ms BIGINT NOT NULL);

CREATE TABLE rig_bench (
  rig TEXT PRIMARY KEY, bench TEXT NOT NULL);

CREATE TABLE recording_picture (
  recording_id TEXT NOT NULL REFERENCES recording (id) ON DELETE CASCADE, picture BIGINT NOT NULL,
  sample_index BIGINT NOT NULL, why TEXT NOT NULL, content_type TEXT NOT NULL, size_bytes BIGINT NOT NULL,
  PRIMARY KEY (recording_id, picture));

CREATE TABLE recording_star (
  recording_id TEXT NOT NULL REFERENCES recording (id) ON DELETE CASCADE, who TEXT NOT NULL,
  PRIMARY KEY (recording_id, who));

CREATE INDEX recording_star_by_person ON recording_star (who);

CREATE TABLE rig_check (
  id $ID, rig TEXT NOT NULL, at_ms BIGINT NOT NULL, kind TEXT NOT NULL, passed BIGINT NOT NULL,
  reason TEXT NOT NULL);

CREATE INDEX rig_check_by_rig ON rig_check (rig, id);

CREATE TABLE rig_check_step (
  check_id BIGINT NOT NULL, place BIGINT NOT NULL, step TEXT NOT NULL, subject TEXT NOT NULL,
  passed BIGINT NOT NULL, has_figure BIGINT NOT NULL, measured DOUBLE PRECISION NOT NULL,
  low DOUBLE PRECISION NOT NULL, high DOUBLE PRECISION NOT NULL, unit TEXT NOT NULL, text TEXT NOT NULL,
  PRIMARY KEY (check_id, place));

CREATE TABLE rig_use (
  rig TEXT NOT NULL, at_ms BIGINT NOT NULL, what TEXT NOT NULL, PRIMARY KEY (rig, at_ms));

CREATE TABLE relay_cycles (
  rig TEXT NOT NULL, line BIGINT NOT NULL, cycles BIGINT NOT NULL, since_ms BIGINT NOT NULL,
  PRIMARY KEY (rig, line));

CREATE TABLE alarm (
  id $ID, kind TEXT NOT NULL, subject TEXT NOT NULL, text TEXT NOT NULL, at_ms BIGINT NOT NULL,
  last_ms BIGINT NOT NULL, times BIGINT NOT NULL, ended_ms BIGINT NOT NULL, acked_ms BIGINT NOT NULL,
  acked_by BIGINT NOT NULL, told BIGINT NOT NULL DEFAULT 0);

CREATE UNIQUE INDEX one_open_alarm ON alarm (kind, subject) WHERE ended_ms = 0;

CREATE TABLE webhook (
  id $ID, url TEXT NOT NULL, secret TEXT NOT NULL, kinds TEXT NOT NULL, created_ms BIGINT NOT NULL,
  delivered_ms BIGINT NOT NULL, failed_ms BIGINT NOT NULL, error TEXT NOT NULL);

CREATE TABLE mail_choice (
  account_id BIGINT PRIMARY KEY REFERENCES account (id), address TEXT NOT NULL, language TEXT NOT NULL,
  kinds TEXT NOT NULL, asked_ms BIGINT NOT NULL, verified_ms BIGINT NOT NULL);

CREATE TABLE outbox (
  id $ID, delivery TEXT NOT NULL UNIQUE, channel TEXT NOT NULL, account_id BIGINT NOT NULL, kind TEXT NOT NULL,
  about TEXT NOT NULL, created_ms BIGINT NOT NULL, state TEXT NOT NULL, attempts BIGINT NOT NULL,
  next_ms BIGINT NOT NULL, ended_ms BIGINT NOT NULL, error TEXT NOT NULL, member TEXT NOT NULL,
  boot TEXT NOT NULL);

CREATE INDEX outbox_due ON outbox (state, next_ms, id);

CREATE INDEX outbox_by_channel ON outbox (channel, state, id);

CREATE TABLE outbox_cursor (
  id BIGINT PRIMARY KEY, event_seq BIGINT NOT NULL, reminded_ms BIGINT NOT NULL);

INSERT INTO outbox_cursor (id, event_seq, reminded_ms) VALUES (1, 0, 0);

CREATE TABLE lab_policy (
  name TEXT PRIMARY KEY, value BIGINT NOT NULL);

CREATE TABLE assignment (
  id $ID, course_id BIGINT NOT NULL, account_id BIGINT NOT NULL, fault_set_id BIGINT NOT NULL,
  name TEXT NOT NULL, bench TEXT NOT NULL, pool TEXT NOT NULL, plan TEXT NOT NULL, rubric TEXT NOT NULL,
  opens_ms BIGINT NOT NULL, due_ms BIGINT NOT NULL, attempts BIGINT NOT NULL, reveal_at_once BIGINT NOT NULL,
  secret TEXT NOT NULL, created_ms BIGINT NOT NULL, deleted BIGINT NOT NULL, version BIGINT NOT NULL DEFAULT 1,
  on_bench BIGINT NOT NULL DEFAULT 0, rubric_version BIGINT NOT NULL DEFAULT 1,
  group_max BIGINT NOT NULL DEFAULT 1);

CREATE INDEX assignment_by_course ON assignment (course_id, id);

CREATE TABLE trial (
  id $ID, assignment_id BIGINT NOT NULL, account_id BIGINT NOT NULL, state TEXT NOT NULL, item BIGINT NOT NULL,
  run TEXT NOT NULL, commitment TEXT NOT NULL, nonce TEXT NOT NULL, truth TEXT NOT NULL, events TEXT NOT NULL,
  created_ms BIGINT NOT NULL, ended_ms BIGINT NOT NULL, answer TEXT NOT NULL, answered_ms BIGINT NOT NULL,
  grade TEXT NOT NULL, released_ms BIGINT NOT NULL, why TEXT NOT NULL, awarded TEXT NOT NULL DEFAULT '',
  graded_by BIGINT NOT NULL DEFAULT 1, copies TEXT NOT NULL DEFAULT '[]');

CREATE INDEX trial_by_person ON trial (assignment_id, account_id, id);

CREATE INDEX trial_by_account ON trial (account_id, id);

CREATE INDEX trial_sealed ON trial (assignment_id) WHERE released_ms = 0;

CREATE TABLE assignment_extension (
  assignment_id BIGINT NOT NULL, account_id BIGINT NOT NULL, due_ms BIGINT NOT NULL,
  PRIMARY KEY (assignment_id, account_id));

CREATE TABLE assignment_group (
  id $ID, assignment_id BIGINT NOT NULL, code TEXT NOT NULL);

CREATE UNIQUE INDEX assignment_group_by_code ON assignment_group (assignment_id, code);

CREATE TABLE assignment_mate (
  assignment_id BIGINT NOT NULL, account_id BIGINT NOT NULL, group_id BIGINT NOT NULL,
  PRIMARY KEY (assignment_id, account_id));

CREATE INDEX assignment_mate_by_group ON assignment_mate (group_id);

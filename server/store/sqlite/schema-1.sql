CREATE TABLE job(
  id TEXT PRIMARY KEY, client_key TEXT UNIQUE, kind TEXT NOT NULL, state TEXT NOT NULL, stage TEXT,
  progress REAL NOT NULL DEFAULT 0, attempt INTEGER NOT NULL DEFAULT 0, losses INTEGER NOT NULL DEFAULT 0,
  crashes INTEGER NOT NULL DEFAULT 0, created INTEGER NOT NULL, started INTEGER, ended INTEGER,
  worker TEXT, lease_hash TEXT, error_code TEXT, error_what TEXT, error_where TEXT, error_fix TEXT, error_proposals TEXT,
  settings TEXT NOT NULL, request TEXT NOT NULL DEFAULT '', owner TEXT NOT NULL DEFAULT '',
  priority INTEGER NOT NULL DEFAULT 0, derived_from TEXT, not_before INTEGER, version INTEGER NOT NULL DEFAULT 1,
  log_lines INTEGER NOT NULL DEFAULT 0, serious_warnings INTEGER,
  reference TEXT NOT NULL DEFAULT '', note TEXT NOT NULL DEFAULT '', reference_changes TEXT NOT NULL DEFAULT ''
) STRICT, WITHOUT ROWID;
CREATE INDEX job_by_owner ON job(owner, id);
CREATE INDEX job_by_state ON job(state, id, kind, created);
CREATE INDEX job_by_owner_and_state ON job(owner, state, id, kind, created);
CREATE INDEX job_by_reference ON job(owner, reference, id) WHERE reference<>'';
CREATE INDEX job_queue ON job(owner, priority DESC, id) WHERE state='queued';
CREATE INDEX job_raised ON job(priority DESC, id) WHERE state='queued' AND priority>0;
CREATE TABLE input(
  job TEXT NOT NULL REFERENCES job(id) ON DELETE CASCADE, name TEXT NOT NULL,
  blob TEXT NOT NULL, bytes INTEGER NOT NULL, extension TEXT NOT NULL, PRIMARY KEY(job, name)
) STRICT, WITHOUT ROWID;
CREATE INDEX input_by_blob ON input(blob);
CREATE TABLE artifact(
  job TEXT NOT NULL REFERENCES job(id) ON DELETE CASCADE, name TEXT NOT NULL,
  blob TEXT NOT NULL, bytes INTEGER NOT NULL, PRIMARY KEY(job, name)
) STRICT, WITHOUT ROWID;
CREATE INDEX artifact_by_blob ON artifact(blob);
CREATE TABLE job_log(
  job TEXT NOT NULL REFERENCES job(id) ON DELETE CASCADE, number INTEGER NOT NULL,
  time INTEGER NOT NULL, text TEXT NOT NULL, PRIMARY KEY(job, number)
) STRICT, WITHOUT ROWID;
CREATE TABLE submitter(
  owner TEXT PRIMARY KEY, queued INTEGER NOT NULL, running INTEGER NOT NULL, served INTEGER NOT NULL DEFAULT 0
) STRICT, WITHOUT ROWID;
CREATE TRIGGER job_made AFTER INSERT ON job BEGIN
  INSERT INTO submitter(owner, queued, running)
    VALUES(new.owner, new.state='queued', new.state IN ('running','cancelling'))
    ON CONFLICT(owner) DO UPDATE SET queued=queued+excluded.queued, running=running+excluded.running;
END;
CREATE TRIGGER job_moved AFTER UPDATE OF state ON job WHEN old.state<>new.state BEGIN
  UPDATE submitter SET queued=queued+(new.state='queued')-(old.state='queued'),
    running=running+(new.state IN ('running','cancelling'))-(old.state IN ('running','cancelling'))
    WHERE owner=new.owner;
END;
CREATE TRIGGER job_gone AFTER DELETE ON job BEGIN
  UPDATE submitter SET queued=queued-(old.state='queued'),
    running=running-(old.state IN ('running','cancelling')) WHERE owner=old.owner;
END;
CREATE TABLE token(
  id TEXT PRIMARY KEY, owner TEXT NOT NULL, scopes TEXT NOT NULL, hash TEXT NOT NULL,
  created INTEGER NOT NULL, expires INTEGER, revoked INTEGER, file TEXT
) STRICT, WITHOUT ROWID;
CREATE TABLE session(hash TEXT PRIMARY KEY, token TEXT NOT NULL, ends INTEGER NOT NULL) STRICT, WITHOUT ROWID;
CREATE TABLE sign_in_link(hash TEXT PRIMARY KEY, token TEXT NOT NULL, expires INTEGER NOT NULL) STRICT, WITHOUT ROWID;
CREATE TABLE upload(
  id TEXT PRIMARY KEY, owner TEXT NOT NULL, input TEXT NOT NULL, extension TEXT NOT NULL, key TEXT NOT NULL,
  length INTEGER NOT NULL, created INTEGER NOT NULL, expires INTEGER NOT NULL, collected INTEGER NOT NULL DEFAULT 0, blob TEXT, bytes INTEGER,
  received INTEGER NOT NULL DEFAULT 0
) STRICT, WITHOUT ROWID;
CREATE INDEX upload_by_owner ON upload(owner) WHERE collected=0;
CREATE INDEX upload_by_blob ON upload(blob) WHERE blob IS NOT NULL;
CREATE TABLE upload_piece(
  upload TEXT NOT NULL REFERENCES upload(id) ON DELETE CASCADE, number INTEGER NOT NULL,
  blob TEXT NOT NULL, bytes INTEGER NOT NULL, PRIMARY KEY(upload, number)
) STRICT, WITHOUT ROWID;
CREATE INDEX upload_piece_by_blob ON upload_piece(blob);
CREATE TABLE scan(
  id TEXT PRIMARY KEY, owner TEXT NOT NULL, created INTEGER NOT NULL,
  blob TEXT NOT NULL, bytes INTEGER NOT NULL, extension TEXT NOT NULL
) STRICT, WITHOUT ROWID;
CREATE INDEX scan_by_owner ON scan(owner, id);
CREATE UNIQUE INDEX scan_by_blob ON scan(blob, owner, extension);
CREATE TABLE profile(
  name TEXT PRIMARY KEY, settings TEXT NOT NULL, changed INTEGER NOT NULL, is_default INTEGER NOT NULL DEFAULT 0
) STRICT, WITHOUT ROWID;
CREATE TABLE remembered(name TEXT PRIMARY KEY, value INTEGER NOT NULL) STRICT, WITHOUT ROWID;
CREATE TABLE stored_object(
  sha256 TEXT NOT NULL, generation TEXT NOT NULL, bytes INTEGER NOT NULL, state TEXT NOT NULL, since INTEGER NOT NULL,
  PRIMARY KEY(sha256, generation)
) STRICT, WITHOUT ROWID;
CREATE UNIQUE INDEX stored_object_live ON stored_object(sha256) WHERE state='live';
CREATE INDEX stored_object_deleting ON stored_object(since) WHERE state='deleting';
CREATE TABLE pending_deletion(blob TEXT PRIMARY KEY) STRICT, WITHOUT ROWID;

-- Texts sort by their bytes, as in SQLite. The leases are apart from the jobs, since each heartbeat writes one: their rows are
-- small, and no index changes with them.
CREATE TABLE job(
  id text COLLATE "C" PRIMARY KEY, client_key text COLLATE "C" UNIQUE, kind text NOT NULL, state text NOT NULL,
  stage text, progress double precision NOT NULL DEFAULT 0, attempt integer NOT NULL DEFAULT 0,
  losses integer NOT NULL DEFAULT 0, crashes integer NOT NULL DEFAULT 0,
  created bigint NOT NULL, started bigint, ended bigint, worker text, lease_hash text,
  error_code text, error_what text, error_where text, error_fix text,
  settings text NOT NULL, request text NOT NULL DEFAULT '', owner text COLLATE "C" NOT NULL DEFAULT '',
  priority integer NOT NULL DEFAULT 0, derived_from text, not_before bigint, version bigint NOT NULL DEFAULT 1,
  log_lines integer NOT NULL DEFAULT 0, serious_warnings integer,
  reference text NOT NULL DEFAULT '', note text NOT NULL DEFAULT '',
  reference_changes text NOT NULL DEFAULT '', error_proposals text
) WITH (fillfactor=70, autovacuum_vacuum_scale_factor=0, autovacuum_vacuum_threshold=5000);
CREATE INDEX job_by_owner ON job(owner, id);
CREATE INDEX job_by_state ON job(state, id);
CREATE INDEX job_by_owner_and_state ON job(owner, state, id);
CREATE INDEX job_by_reference ON job(owner, reference, id) WHERE reference<>'';
CREATE INDEX job_queue ON job(owner, priority DESC, id) WHERE state='queued';
CREATE INDEX job_raised ON job(priority DESC, id) WHERE state='queued' AND priority>0;
CREATE TABLE lease(
  job text COLLATE "C" PRIMARY KEY REFERENCES job(id) ON DELETE CASCADE, ends bigint NOT NULL
) WITH (fillfactor=50, autovacuum_vacuum_scale_factor=0, autovacuum_vacuum_threshold=1000);
CREATE TABLE input(
  job text COLLATE "C" NOT NULL REFERENCES job(id) ON DELETE CASCADE, name text NOT NULL,
  blob text COLLATE "C" NOT NULL, bytes bigint NOT NULL, extension text NOT NULL, PRIMARY KEY(job, name)
);
CREATE INDEX input_by_blob ON input(blob);
CREATE TABLE artifact(
  job text COLLATE "C" NOT NULL REFERENCES job(id) ON DELETE CASCADE, name text NOT NULL,
  blob text COLLATE "C" NOT NULL, bytes bigint NOT NULL, PRIMARY KEY(job, name)
);
CREATE INDEX artifact_by_blob ON artifact(blob);
CREATE TABLE job_log(
  job text COLLATE "C" NOT NULL REFERENCES job(id) ON DELETE CASCADE, number bigint NOT NULL,
  time bigint NOT NULL, text text NOT NULL, PRIMARY KEY(job, number)
);
CREATE TABLE submitter(
  owner text COLLATE "C" PRIMARY KEY, queued bigint NOT NULL, running bigint NOT NULL,
  served bigint NOT NULL DEFAULT 0
) WITH (fillfactor=50, autovacuum_vacuum_scale_factor=0, autovacuum_vacuum_threshold=1000);
CREATE TABLE token(
  id text COLLATE "C" PRIMARY KEY, owner text NOT NULL, scopes text NOT NULL, hash text NOT NULL,
  created bigint NOT NULL, expires bigint, revoked bigint, file text
);
CREATE TABLE upload(
  id text COLLATE "C" PRIMARY KEY, owner text COLLATE "C" NOT NULL, input text NOT NULL, extension text NOT NULL,
  key text NOT NULL, length bigint NOT NULL, created bigint NOT NULL, expires bigint NOT NULL, collected integer NOT NULL DEFAULT 0,
  blob text COLLATE "C", bytes bigint, received bigint NOT NULL DEFAULT 0
);
CREATE INDEX upload_by_owner ON upload(owner) WHERE collected=0;
CREATE INDEX upload_by_blob ON upload(blob) WHERE blob IS NOT NULL;
CREATE TABLE scan(
  id text COLLATE "C" PRIMARY KEY, owner text COLLATE "C" NOT NULL, created bigint NOT NULL,
  blob text COLLATE "C" NOT NULL, bytes bigint NOT NULL, extension text NOT NULL
);
CREATE INDEX scan_by_owner ON scan(owner, id);
CREATE UNIQUE INDEX scan_by_blob ON scan(blob, owner, extension);
CREATE TABLE profile(
  name text COLLATE "C" PRIMARY KEY, settings text NOT NULL, changed bigint NOT NULL,
  is_default integer NOT NULL DEFAULT 0
);
CREATE TABLE remembered(name text COLLATE "C" PRIMARY KEY, value bigint NOT NULL);
CREATE FUNCTION count_job() RETURNS trigger LANGUAGE plpgsql AS $body$
BEGIN
  IF TG_OP='INSERT' THEN
    INSERT INTO submitter(owner, queued, running)
      VALUES(NEW.owner, (NEW.state='queued')::int, (NEW.state IN ('running','cancelling'))::int)
      ON CONFLICT(owner) DO UPDATE SET queued=submitter.queued+excluded.queued,
        running=submitter.running+excluded.running;
    RETURN NULL;
  END IF;
  UPDATE submitter SET queued=queued-(OLD.state='queued')::int,
      running=running-(OLD.state IN ('running','cancelling'))::int WHERE owner=OLD.owner AND TG_OP='DELETE';
  UPDATE submitter SET queued=queued+(NEW.state='queued')::int-(OLD.state='queued')::int,
      running=running+(NEW.state IN ('running','cancelling'))::int-(OLD.state IN ('running','cancelling'))::int
    WHERE TG_OP='UPDATE' AND owner=OLD.owner;
  RETURN NULL;
END $body$;
CREATE TRIGGER job_made AFTER INSERT OR DELETE ON job FOR EACH ROW EXECUTE FUNCTION count_job();
CREATE TRIGGER job_moved AFTER UPDATE OF state ON job FOR EACH ROW WHEN (OLD.state<>NEW.state)
  EXECUTE FUNCTION count_job();
CREATE TABLE stored_object(
  sha256 text COLLATE "C" NOT NULL, generation text COLLATE "C" NOT NULL, bytes bigint NOT NULL, state text NOT NULL,
  since bigint NOT NULL, PRIMARY KEY(sha256, generation)
);
CREATE UNIQUE INDEX stored_object_live ON stored_object(sha256) WHERE state='live';
CREATE INDEX stored_object_deleting ON stored_object(since) WHERE state='deleting';
CREATE TABLE session(hash text COLLATE "C" PRIMARY KEY, token text COLLATE "C" NOT NULL, ends bigint NOT NULL);
CREATE TABLE sign_in_link(hash text COLLATE "C" PRIMARY KEY, token text COLLATE "C" NOT NULL, expires bigint NOT NULL);
CREATE TABLE upload_piece(
  upload text COLLATE "C" NOT NULL REFERENCES upload(id) ON DELETE CASCADE, number integer NOT NULL,
  blob text COLLATE "C" NOT NULL, bytes bigint NOT NULL, PRIMARY KEY(upload, number)
);
CREATE INDEX upload_piece_by_blob ON upload_piece(blob);
CREATE TABLE pending_deletion(blob text COLLATE "C" PRIMARY KEY);

-- What bench_store is compared with: a queue in three bare statements for each cycle, without fair turns, limits, owners,
-- files, leases that end, or notifications. Make its tables in an empty database first:
--   CREATE TABLE job(id bigserial PRIMARY KEY, state text NOT NULL, settings text, result text);
--   CREATE INDEX queue ON job(id) WHERE state='queued';
--   CREATE TABLE event(job bigint, number integer, text text, PRIMARY KEY(job, number));
-- Then, with 32 connections: pgbench -n -M prepared -f tests/bench/bare_queue.sql -c 32 -j 2 -T 10
WITH made AS (INSERT INTO job(state, settings) VALUES('queued', repeat('x', 500)) RETURNING id) INSERT INTO event SELECT id, 1, 'queued' FROM made;
WITH next AS (SELECT id FROM job WHERE state='queued' ORDER BY id LIMIT 1 FOR UPDATE SKIP LOCKED), leased AS (UPDATE job SET state='running' FROM next WHERE job.id=next.id RETURNING job.id), told AS (INSERT INTO event SELECT id, 2, 'leased' FROM leased RETURNING job) SELECT coalesce(max(job), 0) AS leased_job FROM told \gset
WITH ended AS (UPDATE job SET state='succeeded', result=repeat('y', 500) WHERE id=:leased_job AND state='running' RETURNING id) INSERT INTO event SELECT id, 3, 'succeeded' FROM ended;

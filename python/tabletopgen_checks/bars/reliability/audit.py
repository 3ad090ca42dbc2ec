"""Triggers that note who wrote which row, so that the database itself tells of double commits, late writes and
repeated work.
"""

from typing import NamedTuple

# What a job works on, whichever job that is: another one for the same subject would compute it again.
SUBJECT = """CASE NEW.kind WHEN 'execute_task' THEN NEW.id
    WHEN 'record_attempt' THEN NEW.recording_id || ' ' || NEW.attempt_number
    ELSE COALESCE(NEW.recording_id, NEW.dataset_id, NEW.scene_id) END"""
SQLITE_NOW_MS = "CAST((julianday('now') - 2440587.5) * 86400000 AS INTEGER)"
POSTGRES_NOW_MS = "CAST(EXTRACT(EPOCH FROM clock_timestamp()) * 1000 AS BIGINT)"

SQLITE = f"""
CREATE TABLE audited (id INTEGER PRIMARY KEY, what TEXT NOT NULL, subject TEXT NOT NULL);
CREATE TRIGGER audit_of_checkpoints AFTER UPDATE OF output ON checkpoints BEGIN
    INSERT INTO audited (what, subject) VALUES ('stage', NEW.stage || ' ' || NEW.instance || ' ' || NEW.key);
END;
CREATE TRIGGER audit_of_jobs AFTER UPDATE OF state ON jobs
    WHEN NEW.state = 'succeeded' AND OLD.state = 'succeeded' BEGIN
    INSERT INTO audited (what, subject) VALUES ('job', NEW.id);
END;

CREATE TABLE worked (id INTEGER PRIMARY KEY, what TEXT NOT NULL, kind TEXT NOT NULL, subject TEXT NOT NULL,
    job_id TEXT NOT NULL, owner TEXT NOT NULL, by_user TEXT NOT NULL DEFAULT '',
    at_ms INTEGER NOT NULL DEFAULT ({SQLITE_NOW_MS}));
CREATE TRIGGER audit_of_claimed_work AFTER UPDATE OF epoch ON jobs WHEN NEW.epoch > OLD.epoch BEGIN
    INSERT INTO worked (what, kind, subject, job_id, owner) VALUES ('claimed', NEW.kind, {SUBJECT}, NEW.id, NEW.owner);
END;
CREATE TRIGGER audit_of_work AFTER UPDATE OF state ON jobs WHEN OLD.state = 'running' AND (NEW.state = 'succeeded'
    OR NEW.state = 'queued' AND OLD.lease_until <= {SQLITE_NOW_MS}) BEGIN
    INSERT INTO worked (what, kind, subject, job_id, owner) VALUES (
        CASE NEW.state WHEN 'queued' THEN 'orphaned' ELSE 'done' END, NEW.kind, {SUBJECT}, NEW.id, OLD.owner);
END;
"""

POSTGRES = f"""
CREATE TABLE audited (id BIGSERIAL PRIMARY KEY, what TEXT NOT NULL, subject TEXT NOT NULL);
CREATE FUNCTION audit_checkpoint() RETURNS trigger LANGUAGE plpgsql AS $$ BEGIN
    INSERT INTO audited (what, subject) VALUES ('stage', NEW.stage || ' ' || NEW.instance || ' ' || NEW.key);
    RETURN NULL;
END $$;
CREATE TRIGGER audit_of_checkpoints AFTER UPDATE OF output ON checkpoints
    FOR EACH ROW EXECUTE FUNCTION audit_checkpoint();
CREATE FUNCTION audit_job() RETURNS trigger LANGUAGE plpgsql AS $$ BEGIN
    INSERT INTO audited (what, subject) VALUES ('job', NEW.id);
    RETURN NULL;
END $$;
CREATE TRIGGER audit_of_jobs AFTER UPDATE OF state ON jobs FOR EACH ROW
    WHEN (NEW.state = 'succeeded' AND OLD.state = 'succeeded') EXECUTE FUNCTION audit_job();

CREATE TABLE worked (id BIGSERIAL PRIMARY KEY, what TEXT NOT NULL, kind TEXT NOT NULL, subject TEXT NOT NULL,
    job_id TEXT NOT NULL, owner TEXT NOT NULL, by_user TEXT NOT NULL DEFAULT session_user,
    at_ms BIGINT NOT NULL DEFAULT {POSTGRES_NOW_MS});
CREATE FUNCTION audit_claimed_work() RETURNS trigger LANGUAGE plpgsql AS $$ BEGIN
    INSERT INTO worked (what, kind, subject, job_id, owner) VALUES ('claimed', NEW.kind, {SUBJECT}, NEW.id, NEW.owner);
    RETURN NULL;
END $$;
CREATE TRIGGER audit_of_claimed_work AFTER UPDATE OF epoch ON jobs FOR EACH ROW
    WHEN (NEW.epoch > OLD.epoch) EXECUTE FUNCTION audit_claimed_work();
CREATE FUNCTION audit_work() RETURNS trigger LANGUAGE plpgsql AS $$ BEGIN
    INSERT INTO worked (what, kind, subject, job_id, owner) VALUES (
        CASE NEW.state WHEN 'queued' THEN 'orphaned' ELSE 'done' END, NEW.kind, {SUBJECT}, NEW.id, OLD.owner);
    RETURN NULL;
END $$;
CREATE TRIGGER audit_of_work AFTER UPDATE OF state ON jobs FOR EACH ROW
    WHEN (OLD.state = 'running' AND (NEW.state = 'succeeded'
        OR NEW.state = 'queued' AND OLD.lease_until <= {POSTGRES_NOW_MS}))
    EXECUTE FUNCTION audit_work();

CREATE TABLE written (id BIGSERIAL PRIMARY KEY, by_user TEXT NOT NULL DEFAULT session_user,
    inside BIGINT NOT NULL DEFAULT txid_current(),
    takes TEXT NOT NULL, into_table TEXT NOT NULL, job_id TEXT NOT NULL);
CREATE FUNCTION audit_claim() RETURNS trigger LANGUAGE plpgsql AS $$ BEGIN
    INSERT INTO written (takes, into_table, job_id) VALUES (
        CASE WHEN NEW.epoch > OLD.epoch THEN 'claim'
             WHEN OLD.lease_until <= {POSTGRES_NOW_MS} AND NEW.lease_until IS NULL
             THEN 'rescue' ELSE '' END, 'jobs', NEW.id);
    RETURN NULL;
END $$;
CREATE TRIGGER audit_of_claims AFTER UPDATE ON jobs FOR EACH ROW EXECUTE FUNCTION audit_claim();
CREATE FUNCTION audit_write() RETURNS trigger LANGUAGE plpgsql AS $$ BEGIN
    INSERT INTO written (takes, into_table, job_id) VALUES ('', TG_TABLE_NAME, NEW.job_id);
    RETURN NULL;
END $$;
CREATE TRIGGER audit_of_stages AFTER INSERT OR UPDATE ON stages FOR EACH ROW EXECUTE FUNCTION audit_write();
CREATE TRIGGER audit_of_events AFTER INSERT ON events FOR EACH ROW EXECUTE FUNCTION audit_write();
CREATE TRIGGER audit_of_artifacts AFTER INSERT OR UPDATE ON artifacts FOR EACH ROW EXECUTE FUNCTION audit_write();
"""


def install(service):
    """Into the migrated database of a service that runs."""
    if service.store == "postgres":
        service.postgres.sql(POSTGRES, service.database)
        return
    import sqlite3

    connection = sqlite3.connect(service.data_folder / "tabletopgen.sqlite", timeout=30)
    connection.executescript(SQLITE)
    connection.close()


def double_commits(service) -> list:
    """Stages and jobs that were committed a second time."""
    return [
        f"twice: {what} {subject} was committed again"
        for what, subject in service.rows("SELECT what, subject FROM audited ORDER BY id")
    ]


def late_writes(service) -> list:
    """Rows of a job that a worker wrote after another had claimed the job, or had taken it from the worker because its
    lease had run out; PostgreSQL only, where each has its own user.
    """
    return late_among(service.rows("SELECT by_user, inside, takes, into_table, job_id FROM written ORDER BY id"))


def late_among(rows) -> list:
    """The late ones of these writes: user, transaction, `claim`, `rescue` or nothing, table, job. All writes of a
    transaction that claims or rescues a job belong to that."""
    taken = {(inside, job): takes for _, inside, takes, _, job in rows if takes}
    holder, late = {}, []
    for user, inside, _, table, job in rows:
        if takes := taken.get((inside, job)):
            holder[job] = user if takes == "claim" else "no worker"
        elif user.startswith("worker") and holder.get(job, user) != user:
            late.append(f"late: {user} wrote into {table} of a job that {holder[job]} holds")
    return late


class Worked(NamedTuple):
    """A job of any kind was `claimed` by a process, is `done`, or is `orphaned`: its process died, and it waits."""

    what: str
    kind: str
    subject: str
    job_id: str
    owner: str
    at_ms: int


def work(service) -> list:
    """All that happened to jobs, in order."""
    rows = service.rows("SELECT what, kind, subject, job_id, owner, at_ms FROM worked ORDER BY id")
    return [Worked(row[0], row[1], row[2], row[3], row[4], int(row[5])) for row in rows]


def repeated_among(rows) -> list:
    """What was claimed again, or done a second time, after it had been done."""
    finished, wrong = set(), []
    for row in rows:
        about = row.kind, row.subject
        if about in finished and row.what == "claimed":
            wrong.append(f"repeated: {' '.join(about)} was claimed again after it had been done")
        elif about in finished and row.what == "done":
            wrong.append(f"twice: {' '.join(about)} was done twice")
        if row.what == "done":
            finished.add(about)
    return wrong

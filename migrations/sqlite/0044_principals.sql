-- Who may ask for what: keys of clients, sessions of browsers, and the record of what was changed by whom.

CREATE TABLE api_keys (
    id           TEXT PRIMARY KEY,
    tenant_id    TEXT NOT NULL,
    name         TEXT NOT NULL,         -- for people
    digest       TEXT NOT NULL UNIQUE,  -- SHA-256 of the key, which is kept nowhere
    scopes       TEXT NOT NULL,         -- words with spaces between them
    created_at   INTEGER NOT NULL,
    expires_at   INTEGER,
    revoked_at   INTEGER,
    last_used_at INTEGER                   -- to a minute
) STRICT, WITHOUT ROWID;
CREATE INDEX api_keys_of_tenant ON api_keys (tenant_id, id);

CREATE TABLE sessions (
    digest     TEXT PRIMARY KEY,  -- SHA-256 of the cookie
    key_id     TEXT NOT NULL REFERENCES api_keys (id),
    created_at INTEGER NOT NULL,
    expires_at INTEGER NOT NULL
) STRICT, WITHOUT ROWID;
CREATE INDEX sessions_of_key ON sessions (key_id);
CREATE INDEX sessions_by_end ON sessions (expires_at);

CREATE TABLE audit (
    id        TEXT PRIMARY KEY,
    at        INTEGER NOT NULL,
    tenant_id TEXT NOT NULL,
    principal TEXT NOT NULL,
    address   TEXT NOT NULL,  -- of the client; empty for the command line
    action    TEXT NOT NULL,  -- operation of the contract
    subject   TEXT NOT NULL,  -- path of the request
    status    INTEGER NOT NULL   -- of the answer
) STRICT, WITHOUT ROWID;
CREATE INDEX audit_of_tenant ON audit (tenant_id, id);

-- The record is only ever added to.
CREATE TRIGGER audit_is_not_updated BEFORE UPDATE ON audit BEGIN
    SELECT RAISE(ABORT, 'rows of audit are not changed');
END;
CREATE TRIGGER audit_is_not_deleted BEFORE DELETE ON audit BEGIN
    SELECT RAISE(ABORT, 'rows of audit are not changed');
END;

-- Who may ask for what: keys of clients, sessions of browsers, and the record of what was changed by whom.

CREATE TABLE api_keys (
    id           TEXT COLLATE "C" PRIMARY KEY,
    tenant_id    TEXT COLLATE "C" NOT NULL,
    name         TEXT COLLATE "C" NOT NULL,         -- for people
    digest       TEXT COLLATE "C" NOT NULL UNIQUE,  -- SHA-256 of the key, which is kept nowhere
    scopes       TEXT COLLATE "C" NOT NULL,         -- words with spaces between them
    created_at   BIGINT NOT NULL,
    expires_at   BIGINT,
    revoked_at   BIGINT,
    last_used_at BIGINT                   -- to a minute
);
CREATE INDEX api_keys_of_tenant ON api_keys (tenant_id, id);

CREATE TABLE sessions (
    digest     TEXT COLLATE "C" PRIMARY KEY,  -- SHA-256 of the cookie
    key_id     TEXT COLLATE "C" NOT NULL REFERENCES api_keys (id),
    created_at BIGINT NOT NULL,
    expires_at BIGINT NOT NULL
);
CREATE INDEX sessions_of_key ON sessions (key_id);
CREATE INDEX sessions_by_end ON sessions (expires_at);

CREATE TABLE audit (
    id        TEXT COLLATE "C" PRIMARY KEY,
    at        BIGINT NOT NULL,
    tenant_id TEXT COLLATE "C" NOT NULL,
    principal TEXT COLLATE "C" NOT NULL,
    address   TEXT COLLATE "C" NOT NULL,  -- of the client; empty for the command line
    action    TEXT COLLATE "C" NOT NULL,  -- operation of the contract
    subject   TEXT COLLATE "C" NOT NULL,  -- path of the request
    status    BIGINT NOT NULL   -- of the answer
);
CREATE INDEX audit_of_tenant ON audit (tenant_id, id);

-- The record is only ever added to.
CREATE FUNCTION refuse_change_of_audit() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    RAISE EXCEPTION 'rows of audit are not changed';
END $$;
CREATE TRIGGER audit_is_appended_to BEFORE UPDATE OR DELETE ON audit
    FOR EACH ROW EXECUTE FUNCTION refuse_change_of_audit();

"""The statements of one submission, taken from PostgreSQL's log, and played to the bare stores: `pgbench` and
`sqlite3`.

The log names every statement with its parameters, so what is compared is what the service executes today. Ids are
replaced by new ones in every transaction. Savepoints, which only serve to put several submissions into one
transaction, are left out."""

import re
import sqlite3
import subprocess
import threading
import time
import uuid
from pathlib import Path

from tabletopgen_checks.problem import Problem

ENTRY = re.compile(r"^\d{4}-\d\d-\d\d \d\d:\d\d:\d\d\.\d+ \S+ \[(\d+)\] (LOG|DETAIL):  (.*)", re.DOTALL)
STATEMENT = re.compile(r"^(?:execute [^:]*|statement): (.*)", re.DOTALL)
PARAMETER = re.compile(r"\$(\d+) = (NULL|'(?:[^']|'')*')")
UUID = re.compile(r"[0-9a-f]{8}-[0-9a-f]{4}-[0-9a-f]{4}-[0-9a-f]{4}-[0-9a-f]{12}")
CLOCK = "SELECT CAST((julianday('now') - 2440587.5) * 86400000 AS INTEGER)"
ENDS = ("COMMIT", "END")


def recorded(postgres, submit) -> list:
    """Statements and parameters of the transaction that `submit()` makes the service execute."""
    postgres.sql("ALTER SYSTEM SET log_statement = 'all'")
    postgres.sql("SELECT pg_reload_conf()")
    time.sleep(0.5)
    before = postgres.log.stat().st_size
    submit()
    time.sleep(0.5)
    postgres.sql("ALTER SYSTEM RESET log_statement")
    postgres.sql("SELECT pg_reload_conf()")
    with open(postgres.log, "rb") as log:
        log.seek(before)
        text = log.read().decode("utf-8", "replace")
    return transaction_in(text)


def transaction_in(text: str) -> list:
    """The transaction of the log that inserts a scene, without BEGIN and COMMIT."""
    entries = []
    for line in text.splitlines():
        if ENTRY.match(line):
            entries.append(line)
        elif entries:
            entries[-1] += "\n" + line.lstrip("\t")
    open_transactions = {}
    for entry in entries:
        found = ENTRY.match(entry)
        assert found is not None, f"{entry!r} does not begin an entry of the log"
        process, kind, words = found.groups()
        if kind == "DETAIL":
            statements = open_transactions.get(process)
            if statements and words.lower().startswith("parameters:"):
                statements[-1][1].update({int(n): unquoted(value) for n, value in PARAMETER.findall(words)})
            continue
        found = STATEMENT.match(words)
        if not found:
            continue
        statement = found[1].strip()
        if statement.upper().startswith("BEGIN"):
            open_transactions[process] = []
        elif statement.upper().startswith(ENDS):
            statements = open_transactions.pop(process, [])
            if any("INSERT INTO scenes" in sql for sql, _ in statements):
                return [(sql, parameters) for sql, parameters in statements if not is_savepoint(sql)]
        elif process in open_transactions:
            open_transactions[process].append((statement, {}))
    raise Problem("PostgreSQL's log shows no transaction that inserts a scene")


def is_savepoint(sql: str) -> bool:
    return sql.upper().startswith(("SAVEPOINT", "RELEASE", "ROLLBACK TO"))


def unquoted(value: str):
    return None if value == "NULL" else value[1:-1].replace("''", "'")


def ids_of(statements: list) -> list:
    """Ids that the transaction makes: those in its inserts' parameters."""
    return sorted(
        {
            found
            for _, parameters in statements
            for value in parameters.values()
            if value
            for found in UUID.findall(value)
        }
    )


def script_for_pgbench(statements: list) -> str:
    """A script whose every run has ids of its own, out of the client's number and a counter."""
    ids = ids_of(statements)
    lines = ["\\set run :run + 1"]
    lines.append("BEGIN;")
    for sql, parameters in statements:

        def literal(match, parameters=parameters):
            value = parameters.get(int(match[1]))
            return literal_of(value, ids) if int(match[1]) in parameters else match[0]

        flat = " ".join(re.sub(r"--[^\n]*", "", sql).split()).rstrip(";")
        lines.append(re.sub(r"\$(\d+)", literal, flat).replace("\\", "\\\\") + ";")
    lines.append("COMMIT;")
    return "\n".join(lines) + "\n"


def literal_of(value, ids) -> str:
    """The value as SQL, with a new id in place of each recorded one. A literal of unknown type takes that of its
    column.
    """
    if value is None:
        return "NULL"
    parts = []
    for part in re.split(f"({'|'.join(ids)})", value):
        if part in ids:
            parts.append(
                f"('0193{ids.index(part):04d}-0000-7000-8' || lpad(:client_id::text, 3, '0') || '-' || "
                "lpad(:run::text, 12, '0'))"
            )
        elif part:
            # pgbench takes a colon before a letter for a variable, also within quotes.
            parts.append("'" + part.replace("'", "''").replace(":", "' || chr(58) || '") + "'")
    return "''" if not parts else parts[0] if len(parts) == 1 else "(" + " || ".join(parts) + ")"


def on_postgres(postgres, database: str, statements: list, clients: int, seconds: float, folder: Path) -> tuple:
    """Seconds of each transaction and of the whole run, by pgbench."""
    script = folder / "submit.sql"
    script.write_text(script_for_pgbench(statements), encoding="utf-8")
    for old in folder.glob("pgbench_log*"):
        old.unlink()
    start = int(time.time() * 1000) % 10**11
    command = [
        postgres.programs / "pgbench",
        "--no-vacuum",
        "--protocol",
        "prepared",
        "--client",
        clients,
        "--jobs",
        min(clients, 2),
        "--time",
        int(seconds),
        "--log",
        "--log-prefix",
        folder / "pgbench_log",
        "--file",
        script,
        "--define",
        f"run={start}",
        postgres.url(database),
    ]
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, cwd=folder)
    lines = [line for log in folder.glob("pgbench_log*") for line in log.read_text().splitlines()]
    if done.returncode != 0 or "aborted" in done.stderr or not lines:
        raise Problem(f"pgbench failed: {done.stderr.strip()[-800:]}")
    return [int(line.split()[2]) / 1e6 for line in lines], float(seconds)


def on_sqlite(path: Path, statements: list, clients: int, seconds: float) -> tuple:
    """Seconds of each transaction and of the whole run. SQLite has one writer at a time, so the clients take turns."""
    translated = for_sqlite(statements)
    ids = ids_of(statements)
    connection = sqlite3.connect(path, timeout=30, isolation_level=None, check_same_thread=False)
    for pragma in ("journal_mode = WAL", "synchronous = FULL", "foreign_keys = ON"):
        connection.execute(f"PRAGMA {pragma}")
    turn, durations, began = threading.Lock(), [], time.perf_counter()

    def client():
        while (asked := time.perf_counter()) - began < seconds:
            fresh = {one: str(uuid.uuid4()) for one in ids}
            with turn:
                connection.execute("BEGIN IMMEDIATE")
                for sql, parameters in translated:
                    connection.execute(
                        sql, {str(n): renewed(value, fresh) for n, value in parameters.items()}
                    ).fetchall()
                connection.execute("COMMIT")
            durations.append(time.perf_counter() - asked)

    threads = [threading.Thread(target=client) for _ in range(clients)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    took = time.perf_counter() - began
    connection.close()
    return durations, took


def renewed(value, fresh: dict):
    for old, new in fresh.items():
        if value and old in value:
            value = value.replace(old, new)
    return value


def for_sqlite(statements: list) -> list:
    """The same statements in SQLite's dialect; notifications and row locks have no counterpart there."""
    translated = []
    for sql, parameters in statements:
        lower = sql.lower()
        if "pg_notify" in lower or lower.startswith(("notify", "set ", "lock ")) or "pg_advisory" in lower:
            continue
        if "clock_timestamp" in lower or "extract(epoch" in lower:
            translated.append((CLOCK, {}))
            continue
        sql = re.sub(r"(?i)\bfor (no key )?update( of \w+)?( skip locked)?", "", sql)
        translated.append((re.sub(r"(?i)::\w+", "", sql), parameters))
    return translated

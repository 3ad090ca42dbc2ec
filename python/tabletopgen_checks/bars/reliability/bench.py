"""What all parts share: the programs, the private PostgreSQL and S3 (started when first wanted), and services over
them.
"""

import contextlib
import os
import shutil
from dataclasses import dataclass, field
from pathlib import Path

from tabletopgen_checks.service.postgres import Postgres
from tabletopgen_checks.service.s3 import S3
from tabletopgen_checks.service.server import Server

STORES = ("sqlite", "postgres")


class Bench:
    """Programs and servers of one run of the bar."""

    def __init__(self, given, name="reliability"):
        """`name` is that of the folder of its services."""
        self.given, self.binary = given, given.binary
        self.folder = given.work / name
        self.folder.mkdir(parents=True, exist_ok=True)
        self.stack, self._postgres, self._s3, self.services = contextlib.ExitStack(), None, None, 0

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        return self.stack.__exit__(*exception)

    @property
    def postgres(self) -> Postgres:
        if self._postgres is None:
            self._postgres = self.stack.enter_context(Postgres(self.given.target_dir))
        return self._postgres

    @property
    def s3(self) -> S3:
        if self._s3 is None:
            self._s3 = self.stack.enter_context(S3(self.given.target_dir, self.folder / "s3.log"))
        return self._s3

    def stores(self) -> list:
        """Those that this run measures."""
        return [store for store in STORES if store in self.given.stores.replace(",", " ").split()]

    def service(self, store, name, **more) -> "Service":
        self.services += 1
        return Service(self, store, f"{name}-{self.services}", **more)


@dataclass
class Service:
    """One service on fresh data: on SQLite one process, on PostgreSQL and S3 processes for requests and for work.

    `api` answers requests. `workers` do the work; on SQLite the only process is both. Each process on PostgreSQL
    connects as a database user of its own (api0, worker0, ...), so that the database can tell who wrote a row."""

    bench: Bench
    store: str
    name: str
    settings: dict = field(default_factory=dict)
    workers_wanted: int = 1
    apis_wanted: int = 1
    within: tuple = ()
    environment: dict = field(default_factory=dict)
    # Where the workers find the database and S3, if that is another address than that of everybody.
    database_at: str = ""
    s3_url: str = ""
    # Another PostgreSQL than that of everybody.
    postgres: Postgres | None = None
    # A folder of data that is there already, such as a small disk.
    data: Path | None = None

    def __post_init__(self):
        if self.store == "postgres":
            self.postgres = self.postgres or self.bench.postgres
        self.folder = self.bench.folder / self.name
        self.apis, self.workers, self.count = [], [], 0
        # The name of each server in the database.
        self.users: dict[Server, str | None] = {}

    def __enter__(self):
        shutil.rmtree(self.folder, ignore_errors=True)
        self.folder.mkdir(parents=True)
        try:
            if self.store == "sqlite":
                self.apis = [self._server("all", None)]
                self.workers = self.apis
            else:
                self.sql_server.create(self.database)
                self.bench.s3.create(self.bucket)
                self.apis = [self._server("api", f"api{k}") for k in range(self.apis_wanted)]
                self.workers = [self.another_worker() for _ in range(self.workers_wanted)]
            for server in self.servers:
                self.start(server)
        except BaseException:
            self.__exit__(None)
            raise
        return self

    def __exit__(self, *_):
        for server in self.servers:
            # What shall be seen of an orderly stop is seen before; here nothing is waited for.
            server.kill()
        if self.store == "postgres":
            self.sql_server.drop(self.database)
        if not self.bench.given.keep:
            shutil.rmtree(self.folder, ignore_errors=True)

    @property
    def api(self) -> Server:
        return self.apis[0]

    @property
    def sql_server(self) -> Postgres:
        assert self.postgres is not None, "a service on SQLite has no PostgreSQL"
        return self.postgres

    @property
    def servers(self) -> list:
        return list(dict.fromkeys([*self.apis, *self.workers]))

    @property
    def database(self) -> str:
        return self.name.replace("-", "_")

    @property
    def bucket(self) -> str:
        return self.name.replace("_", "-")

    @property
    def data_folder(self) -> Path:
        """Of the one process on SQLite."""
        return self.data or self.folder / "data"

    def start(self, server: Server):
        """Waits until it answers; from a worker in another network only until it says where it listens."""
        server.launch()
        if server.role == "worker" and self.database_at.startswith(("198.18.",)):
            server.wait_until_announced()
        else:
            server.wait_until_ready()

    def another_worker(self) -> Server:
        """A worker that is not started yet, in place of one that died or beside the others."""
        if self.store == "sqlite":
            return self._server("all", None)
        user = f"worker{self.count}"
        self.count += 1
        return self._server("worker", user)

    def replace(self, dead: Server) -> Server:
        """A new process, started and not waited for, in place of a dead one."""
        fresh = self._server(dead.role, self.users[dead]) if dead in self.apis else self.another_worker()
        self.apis = [fresh if server is dead else server for server in self.apis]
        self.workers = [fresh if server is dead else server for server in self.workers]
        fresh.launch()
        return fresh

    def _server(self, role, user) -> Server:
        data = self.data_folder
        if self.store == "postgres":
            data = self.folder / user
            # Several threads may start servers at once.
            exists = "EXCEPTION WHEN duplicate_object OR unique_violation THEN NULL"
            self.sql_server.sql(f"DO $$ BEGIN CREATE ROLE {user} LOGIN SUPERUSER; {exists}; END $$")
        data.mkdir(parents=True, exist_ok=True)
        settings = self.storage(role, user) | self.settings
        arguments = [part for key, value in settings.items() for part in ("--set", f"{key}={value}")]
        environment = self.environment | (self.bench.s3.environment() if self.store == "postgres" else {})
        log = self.folder / f"{user or 'server'}.log"
        # Where the workers have a network of their own, requests are answered outside of it.
        within = () if role == "api" and self.database_at else self.within
        server = Server(self.bench.binary, data, log, environment, arguments, role, within)
        self.users[server] = user
        return server

    def storage(self, role, user) -> dict:
        """Settings that say where rows and bytes are."""
        if self.store == "sqlite":
            return {}
        address, url = (self.database_at, self.s3_url) if role == "worker" else ("", "")
        database = self.sql_server.url(self.database, user, address or None)
        return {"store.database": database} | self.bench.s3.settings(self.bucket, url or None)

    def rows(self, statement: str) -> list:
        """Of the database, as lists of text."""
        if self.store == "postgres":
            return self.sql_server.sql(statement, self.database)
        import sqlite3

        connection = sqlite3.connect(self.data_folder / "tabletopgen.sqlite", timeout=30)
        try:
            with connection:
                return [["" if cell is None else str(cell) for cell in row] for row in connection.execute(statement)]
        finally:
            connection.close()


def cores() -> list:
    return sorted(os.sched_getaffinity(0))

"""Every secret that a run used, and every place that it must not be in.

What is searched is known by a mark: something that has to be there, such as the id of a key. A place without its mark
was not read, or holds something else.
"""

import base64
import re
from pathlib import Path
from urllib.parse import quote

from tabletopgen_checks.problem import Problem

PREFIXES = ("tt_", "whsec_")
# Places that are the database or a copy of it: it has secrets of webhooks, with which it signs.
DATABASES = ("file of the database", "rows of PostgreSQL", "files of the backup")


class Secrets:
    """Secrets by a name that may be shown, and where they were searched for."""

    def __init__(self):
        # The secret, and the places that it may be in.
        self.known: dict[str, tuple] = {}
        # Bytes that were read, by place.
        self.read: dict[str, int] = {}
        self.found: list[str] = []

    def add(self, name: str, secret: str, allowed: tuple = ()) -> str:
        """Remembers it, without what every secret of its kind begins with, and gives it back."""
        kept = secret
        for prefix in PREFIXES:
            kept = kept.removeprefix(prefix)
        self.known[f"{name} ({len(self.known)})"] = kept, allowed
        return secret

    def forms(self, secret: str) -> list:
        """How it may stand in a file: as it is, escaped in an address, or in base64 wherever that begins."""
        raw = secret.encode()
        shifted = [base64.b64encode(b"\0" * shift + raw)[4:-4] for shift in range(3)]
        return [raw, quote(secret, safe="").encode(), *shifted]

    def search(self, place: str, content: bytes, mark: "str | None" = None):
        """Notes which secrets are there. `mark` is a text that must be."""
        if mark is not None and mark.encode() not in content:
            raise Problem(f"the search for secrets read {len(content)} bytes of the {place}, and {mark!r} is not there")
        self.read[place] = self.read.get(place, 0) + len(content)
        for name, (secret, allowed) in self.known.items():
            if place not in allowed and any(form in content for form in self.forms(secret)):
                self.found.append(f"{name} in the {place}")

    def search_files(self, place: str, folder: Path, pattern: str = "*", mark: "str | None" = None):
        files = [path for path in sorted(folder.rglob(pattern)) if path.is_file()]
        self.search(place, b"\0".join(path.read_bytes() for path in files), mark)

    def search_service(self, service):
        """The logs, and the whole database, of a service that still runs."""
        for log in sorted(service.folder.glob("*.log")):
            self.search("log of the server", log.read_bytes())
        if service.store == "sqlite":
            self.search_files("file of the database", service.data_folder, "tabletopgen.sqlite*")
        else:
            self.search("rows of PostgreSQL", rows_of_postgres(service))


def rows_of_postgres(service) -> bytes:
    """Every row of every table, as text."""
    tables = [name for (name,) in service.rows("SELECT tablename FROM pg_tables WHERE schemaname = 'public'")]
    rows = (service.rows(f'SELECT one::text FROM "{name}" AS one') for name in sorted(tables))
    return "\n".join("\x1f".join(row) for table in rows for row in table).encode()


def cookie_of(headers) -> str:
    """The session of an answer."""
    found = re.search(r"tt_session=([^;]+)", headers.get("set-cookie") or "")
    if not found:
        raise Problem("a login was answered without a cookie")
    return found[1]

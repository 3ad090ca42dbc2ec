"""The digest of a folder: of the paths and bytes of all its files."""

from __future__ import annotations

import hashlib
from pathlib import Path

from tabletopgen._sync.connection import digest_of


def digest_of_folder(folder: Path) -> str:
    """The SHA-256 of all files below a folder."""
    if not folder.is_dir():
        raise ValueError(f"{folder} is no folder; name one that exists")
    whole = hashlib.sha256()
    for path in sorted(path for path in folder.rglob("*") if path.is_file()):
        whole.update(path.relative_to(folder).as_posix().encode() + b"\0")
        whole.update(bytes.fromhex(digest_of(path)))
    return whole.hexdigest()

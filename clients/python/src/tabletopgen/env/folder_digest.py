"""The digest of a folder: of the paths and bytes of all its files."""

from __future__ import annotations

import hashlib
from pathlib import Path

PART_BYTES = 1 << 20


def digest_of_folder(folder: Path) -> str:
    """The SHA-256 of all files below a folder."""
    if not folder.is_dir():
        raise ValueError(f"{folder} is no folder; name one that exists")
    whole = hashlib.sha256()
    for path in sorted(path for path in folder.rglob("*") if path.is_file()):
        whole.update(path.relative_to(folder).as_posix().encode() + b"\0")
        whole.update(digest_of_file(path))
    return whole.hexdigest()


def digest_of_file(path: Path) -> bytes:
    """The SHA-256 of a file, which may be larger than the memory."""
    found = hashlib.sha256()
    with open(path, "rb") as file:
        while part := file.read(PART_BYTES):
            found.update(part)
    return found.digest()

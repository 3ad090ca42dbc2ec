"""Archives that the server sends, unpacked into folders."""

from __future__ import annotations

import os
import shutil
import tarfile
import tempfile
import zipfile
from pathlib import Path


def unpack_zip(archive: Path, folder: Path) -> Path:
    """Unpacks an archive below a folder: the path of the one folder at its top, else of the folder."""
    with tempfile.TemporaryDirectory(dir=folder, prefix=".unpacked-") as place:
        with zipfile.ZipFile(archive) as opened:
            opened.extractall(place)
        return moved(Path(place), folder)


def unpack_tar(archive: Path, folder: Path) -> Path:
    """The same of an archive of tar; only plain files and folders below `folder` are written."""
    with tempfile.TemporaryDirectory(dir=folder, prefix=".unpacked-") as place:
        with tarfile.open(archive) as opened:
            for member in opened:
                target = (Path(place) / member.name).resolve()
                if not target.is_relative_to(Path(place).resolve()):
                    raise ValueError(f"the archive has a file outside of its folder: {member.name}")
                if content := opened.extractfile(member) if member.isreg() else None:
                    target.parent.mkdir(parents=True, exist_ok=True)
                    with open(target, "wb") as file:
                        shutil.copyfileobj(content, file)
        return moved(Path(place), folder)


def moved(source: Path, target: Path) -> Path:
    """Files appear whole, one by one; those of another download of the same scene stay."""
    tops = list(source.iterdir())
    for path in source.rglob("*"):
        if path.is_file():
            place = target / path.relative_to(source)
            place.parent.mkdir(parents=True, exist_ok=True)
            os.replace(path, place)
    return target / tops[0].name if len(tops) == 1 and tops[0].is_dir() else target

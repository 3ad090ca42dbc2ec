"""A dataset of episodes that `tabletopgen episodes` wrote: records, and the numbers of frames."""

from __future__ import annotations

import json
from collections.abc import Iterable
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tabletopgen._media import imported

RECORDS = "records.jsonl"
# Formats with tables of frames, the one that is read fastest first.
READ = ("parquet-png", "lerobot-v2.1", "lerobot-v2.1-images", "lerobot-v3.0", "lerobot-v3.0-images")
COLUMNS = ("observation.state", "action", "servo_command")

Numbers = NDArray[np.float32]


class RecordedDataset:
    """The folder of one format, or the folder above with several of them."""

    def __init__(self, folder: str | Path):
        folder = Path(folder)
        places = [folder, *(folder / name for name in READ)]
        found = [place for place in places if (place / RECORDS).is_file() and tables(place).is_dir()]
        if not found:
            raise ValueError(
                f"no dataset to read in {folder}: it has no {RECORDS} beside tables of frames. Give the folder of --out of "
                f"`tabletopgen episodes`, recorded with --format {READ[0]} or one for LeRobot"
            )
        self.folder = found[0]

    @cached_property
    def entries(self) -> list[dict[str, Any]]:
        """The lines of `records.jsonl`: one for each episode, with its record."""
        with open(self.folder / RECORDS, encoding="utf-8") as lines:
            return [json.loads(line) for line in lines]

    def frames(self, episode: int, columns: Iterable[str] = COLUMNS) -> dict[str, Numbers]:
        """Columns of an episode, (frames, numbers) each."""
        name = f"episode_{episode:06d}"
        one = self.folder / "episodes" / name / "frames.parquet"
        wanted = list(columns)
        read = imported("pyarrow.parquet", "pyarrow").read_table
        if one.is_file():
            table = read(one, columns=wanted)
        else:
            table = read(tables(self.folder), columns=[*wanted, "episode_index"], filters=[("episode_index", "=", episode)])
        if table.num_rows == 0:
            raise ValueError(f"{self.folder} has no frames of episode {episode}; it has {len(self.entries)} episodes, which count from 0")
        return {column: np.stack(table[column].to_pylist()).astype(np.float32) for column in wanted}


def tables(folder: Path) -> Path:
    """Where a format has its tables of frames."""
    own = folder / "episodes"
    return own if own.is_dir() else folder / "data"

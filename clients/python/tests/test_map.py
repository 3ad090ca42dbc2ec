"""`map` while its server is killed twice and its client once: nothing is lost, and nothing is made twice."""

from __future__ import annotations

import random
import socket
import subprocess
import sys
import time
from itertools import product
from pathlib import Path
from typing import Any

import pytest

from tabletopgen import Client

COLORS = ["red", "blue", "green", "white", "black"]
NOUNS = ["mug", "apple", "plate", "bowl", "book", "spoon", "fork", "vase", "candle", "banana"]
MORE = ["one spoon", "two forks", "two pens", "a book", "an orange"]
# Prints a line for each result.
CLIENT = """
import sys
from tabletopgen import Client
url, *texts = sys.argv[1:]
with Client(url, progress=False) as client:
    for result in client.map(texts, seeds=[1], labels={"of": "map"}, window=4):
        print(result.index, result.scene and result.scene.id, result.error, flush=True)
"""


def sentences(count: int) -> list[str]:
    """A fifth of them different, so that most scenes are of stages that are found; each is a scene of its own."""
    different = [f"a {color} {noun} and {more}" for noun, more, color in product(NOUNS, MORE, COLORS)][: max(1, count // 5)]
    return [different[number % len(different)] for number in range(count)]


class Server:
    """A server on a port that stays the same when it is killed and started again."""

    def __init__(self, program: Path, folder: Path):
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            listen = f"127.0.0.1:{free.getsockname()[1]}"
        self.url = f"http://{listen}"
        self.command = [str(program), "serve", "--listen", listen, "--data-dir", str(folder / "data")]
        self.log = folder / "log"
        self.start()

    def start(self) -> None:
        with open(self.log, "ab") as log:
            self.process = subprocess.Popen(self.command, stdin=subprocess.DEVNULL, stdout=log, stderr=log)

    def kill(self) -> None:
        self.process.kill()
        self.process.wait()


def results(server: Server, texts: list[str], killed_after: int, pause_secs: float, stop_after: int | None = None) -> list[str]:
    """Lines of a client beside a server that is killed after some of them; the client is killed where it is to stop."""
    lines: list[str] = []
    command = [sys.executable, "-c", CLIENT, server.url, *texts]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as client:
        assert client.stdout is not None
        for line in client.stdout:
            lines.append(line)
            if len(lines) == killed_after:
                server.kill()
                time.sleep(pause_secs)
                server.start()
            if len(lines) == stop_after:
                client.kill()
                break
    return lines


def test_nothing_is_lost_or_made_twice_when_server_and_client_are_killed(
    program: Path, tmp_path: Path, pytestconfig: pytest.Config
) -> None:
    count: Any = pytestconfig.getoption("--sentences")
    texts = sentences(count)
    chance, server = random.Random(7), Server(program, tmp_path)
    half = len(texts) // 2
    try:
        first = results(server, texts, chance.randrange(1, half), chance.uniform(0, 1), half)
        second = results(server, texts, chance.randrange(half, len(texts) - 4), chance.uniform(0, 1))
        with Client(server.url, progress=False) as client:
            listed = [scene.id for scene in client.scenes(label="of:map")]
    finally:
        server.kill()
    assert second[:half] == first, "the second client found the scenes of the first"
    rows = [line.split(maxsplit=2) for line in second]
    assert [int(index) for index, _, _ in rows] == list(range(len(texts)))
    assert [error.strip() for _, _, error in rows] == ["None"] * len(texts)
    ids = [scene for _, scene, _ in rows]
    assert len(set(ids)) == len(texts) and sorted(listed) == sorted(ids)

"""Policies on a server that speaks the websocket protocol of openpi, as its `WebsocketClientPolicy` 0.1.2 does.

A message is MessagePack, in which an array of NumPy is a map with the keys `__ndarray__`, `data`, `dtype` and `shape`
as bytes. A server sends its metadata when a client connects. Then it answers each observation with a map whose
`actions` are rows of actions, (horizon, numbers). Where the policy fails it answers with text, and ends the connection.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from contextlib import ExitStack
from typing import Any

import numpy as np

from tabletopgen._media import imported
from tabletopgen.env.policy import Description, PolicyFailedError, PolicyUnavailableError
from tabletopgen.env.scene_env import Observation
from tabletopgen.env.vectors import Vector

# Time for a server to come up, and for one answer: the first one may wait until a network is compiled.
CONNECT_S, ANSWER_S, RETRY_S = 60.0, 600.0, 0.5
# Kinds of numbers that have no portable bytes: records, Python objects, complex numbers.
REFUSED = "VOc"


class ServerPolicy:
    """The policy of a server. It gets the observation and the instruction as `prompt`, and its rows of actions are
    carried out one a step, up to `chunk` of each answer."""

    def __init__(self, address: str, description: Description, chunk: int | None = None, connect_s: float = CONNECT_S):
        if chunk is not None and chunk < 1:
            raise ValueError(f"a chunk of {chunk} actions carries out nothing; give 1 or more")
        self.address, self.chunk, self.numbers = address, chunk, len(description["action_names"])
        self._packer = imported("msgpack").Packer(default=packed)
        self._errors = imported("websockets.exceptions", "websockets")
        self._rows: list[Vector] = []
        self._prompt = str(description["instruction"])
        self._open = ExitStack()
        self._connection: Any = None
        self._connect_s = connect_s
        # What the server says about its policy.
        self.metadata = self._connect()

    def _connect(self) -> Any:
        """Connects to the server, and returns its metadata."""
        try:
            self._connection = self._connected()
            return unpacked(self._received())
        except BaseException:
            self.close()
            raise

    def _connected(self) -> Any:
        connect = imported("websockets.sync.client", "websockets").connect
        until_s = time.monotonic() + self._connect_s
        while True:
            try:
                # A server that computes an answer leaves pings without one.
                return self._open.enter_context(connect(self.address, compression=None, max_size=None, ping_interval=None))
            except OSError as error:
                if time.monotonic() >= until_s:
                    raise PolicyUnavailableError(
                        f"no policy server answered at {self.address} within {self._connect_s:g} s ({error}); start it, then give the"
                        " command again"
                    ) from error
                time.sleep(RETRY_S)
            except (self._errors.WebSocketException, ValueError) as error:
                raise PolicyUnavailableError(f"{self.address} cannot be connected to ({error}); name the server of a policy") from error

    def reset(self, info: Mapping[str, Any]) -> None:
        """Begins an episode: rows of the one before are dropped."""
        self._rows, self._prompt = [], str(info["instruction"])

    def act(self, observation: Observation) -> Vector:
        """The next row, of a new answer if those of the last one are used up."""
        if not self._rows:
            rows = self.actions({**observation, "prompt": self._prompt})
            self._rows = list(rows[: self.chunk])
        return self._rows.pop(0)

    def actions(self, observation: Mapping[str, Any]) -> Vector:
        """All rows that the server answers to an observation."""
        if self._connection is None:
            self._connect()
        connection: Any = self._connection
        try:
            connection.send(self._packer.pack(observation))
        except self._errors.ConnectionClosed as error:
            raise self._gone(error) from error
        answer = unpacked(self._received())
        rows = np.asarray(answer.get("actions") if isinstance(answer, Mapping) else None)
        if rows.ndim != 2 or len(rows) == 0 or rows.shape[1] != self.numbers or rows.dtype.kind not in "fiu":
            keys = sorted(map(str, answer)) if isinstance(answer, Mapping) else type(answer).__name__
            raise PolicyFailedError(
                f"{self.address} answered with {keys}, where `actions` of shape (horizon, {self.numbers}) is expected, not"
                f" {rows.shape}; choose the --action-mode that the policy was trained for"
            )
        return rows.astype(np.float32)

    def _received(self) -> bytes:
        try:
            answer = self._connection.recv(timeout=ANSWER_S)
        except (self._errors.ConnectionClosed, TimeoutError) as error:
            raise self._gone(error) from error
        if isinstance(answer, str):
            # A server of openpi ends the connection after that.
            self.close()
            raise PolicyFailedError(f"the policy of {self.address} failed: {answer.strip()[-2000:]}")
        return bytes(answer)

    def _gone(self, error: Exception) -> PolicyUnavailableError:
        return PolicyUnavailableError(
            f"the connection to {self.address} ended ({error or type(error).__name__}); start the server, then give the command again"
        )

    def close(self) -> None:
        """Ends the connection."""
        self._open.close()
        self._connection = None


def packed(value: Any) -> Any:
    """What MessagePack has for an array or a number of NumPy."""
    if isinstance(value, (np.ndarray, np.generic)):
        if value.dtype.kind in REFUSED:
            raise ValueError(f"an array of {value.dtype} cannot be sent; send numbers, truth values or text")
        if isinstance(value, np.ndarray):
            return {b"__ndarray__": True, b"data": value.tobytes(), b"dtype": value.dtype.str, b"shape": value.shape}
        return {b"__npgeneric__": True, b"data": value.item(), b"dtype": value.dtype.str}
    raise TypeError(f"a {type(value).__name__} cannot be sent; send arrays, numbers or text")


def restored(found: Mapping[Any, Any]) -> Any:
    """The array or number of NumPy that a map stands for, or the map."""
    if b"__ndarray__" in found or b"__npgeneric__" in found:
        kind = np.dtype(found[b"dtype"])
        if kind.kind in REFUSED:
            raise ValueError(f"an array of {kind} was received, which has no portable bytes")
        if b"__npgeneric__" in found:
            return kind.type(found[b"data"])
        return np.frombuffer(found[b"data"], dtype=kind).reshape(found[b"shape"])
    return found


def unpacked(content: bytes) -> Any:
    """The values of a message."""
    msgpack = imported("msgpack")
    try:
        return msgpack.unpackb(content, object_hook=restored)
    except (ValueError, KeyError, TypeError) as error:
        raise PolicyFailedError(f"the answer of a policy server is no message of openpi's protocol: {error}") from error

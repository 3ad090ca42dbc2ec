"""Server-sent events, from bytes as they come. Lines end at line feeds alone: JSON may contain other separators."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class SentEvent:
    """One message of a stream. One without data only says where a stream begins."""

    id: str
    data: str


class Parser:
    """Takes pieces of a stream of any size and gives the messages that are complete."""

    def __init__(self) -> None:
        self.rest = b""
        self.id = ""
        self.is_named = False
        self.data: list[str] = []

    def feed(self, piece: bytes) -> list[SentEvent]:
        *lines, self.rest = (self.rest + piece).split(b"\n")
        return [event for line in lines if (event := self._line(line.removesuffix(b"\r").decode("utf-8", "replace")))]

    def _line(self, line: str) -> SentEvent | None:
        if not line:
            event = SentEvent(self.id, "\n".join(self.data)) if self.data or self.is_named else None
            self.data, self.is_named = [], False
            return event
        name, _, value = line.partition(":")
        value = value.removeprefix(" ")
        if name == "data":
            self.data.append(value)
        elif name == "id":
            self.id, self.is_named = value, True
        return None

"""A server with scripted answers, for faults that the real one does not have on demand."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from types import TracebackType
from typing import Any

SCENE_ID = "0197f0c6-0000-7000-8000-000000000001"
JOB_ID = "0197f0c6-0000-7000-8000-000000000002"
AT = "2026-01-31T12:00:00.000Z"


@dataclass
class Received:
    """A request as it arrived."""

    method: str
    path: str
    headers: Mapping[str, str]
    body: bytes


@dataclass
class Answer:
    """An answer, or a part of one: with `cut`, the connection ends after so many bytes of the body."""

    status: int = 200
    body: bytes = b""
    headers: Mapping[str, str] = field(default_factory=dict)
    cut: int | None = None
    delay_secs: float = 0.0


Script = Sequence[Answer] | Callable[[Received], Answer]


def as_json(value: Any, status: int = 200, **headers: str) -> Answer:
    named = {name.replace("_", "-"): text for name, text in headers.items()}
    return Answer(status, json.dumps(value).encode(), {"content-type": "application/json", **named})


def problem(status: int, kind: str, code: str, retry_after: str = "", errors: Sequence[Mapping[str, str]] = ()) -> Answer:
    body = {
        "type": f"urn:tabletopgen:problem:{kind}",
        "title": "no",
        "status": status,
        "code": code,
        "detail": "do it otherwise",
        "request_id": "r-1",
        "errors": errors,
    }
    headers = {"content-type": "application/problem+json"} | ({"retry-after": retry_after} if retry_after else {})
    return Answer(status, json.dumps(body).encode(), headers)


def job(state: str = "queued", **more: Any) -> dict[str, Any]:
    links = dict.fromkeys(("self", "events", "stages", "scene", "dataset", "recording", "execution"), "/")
    fields = dict.fromkeys(("scene_id", "dataset_id", "recording_id", "retry_of", "from_stage", "failure", "started_at", "finished_at"))
    return {**fields, "id": JOB_ID, "kind": "generate", "state": state, "attempt": 0, "created_at": AT, "links": links, **more}


def scene(state: str = "pending", **more: Any) -> dict[str, Any]:
    fields = dict.fromkeys(("verdict", "failure", "parent", "metrics", "summary"))
    return {
        **fields,
        "id": SCENE_ID,
        "state": state,
        "seed": 7,
        "labels": {},
        "created_at": AT,
        "updated_at": AT,
        "request": {"version": 1, "input": {"kind": "text", "text": "a mug"}, "seed": 7, "options": {}},
        "job": job(),
        "links": {**dict.fromkeys(("self", "bundle", "files", "preview", "artifacts"), "/"), "events": None},
        **more,
    }


def event(seq: int, kind: str, **data: Any) -> bytes:
    value = {"seq": seq, "at": AT, "kind": kind, "data": data}
    return f"id: {seq}\nevent: {kind}\ndata: {json.dumps(value, ensure_ascii=False)}\n\n".encode()


def stream(*parts: bytes, cut: int | None = None) -> Answer:
    return Answer(200, b"".join(parts), {"content-type": "text/event-stream"}, cut)


class Fake:
    """Gives the answers of a list in their order, the last one again and again, or those of a function."""

    def __init__(self, answers: Script):
        self.answers = answers
        self.received: list[Received] = []
        self.lock = threading.Lock()
        fake = self

        class Handler(BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"

            def handle_one(self) -> None:
                length = int(self.headers.get("content-length", 0))
                body = self.rfile.read(length)
                named = {name.lower(): value for name, value in self.headers.items()}
                answer = fake.next(Received(self.command, self.path, named, body))
                time.sleep(answer.delay_secs)
                self.send_response(answer.status)
                for name, value in answer.headers.items():
                    self.send_header(name, value)
                self.send_header("content-length", str(len(answer.body)))
                self.end_headers()
                self.wfile.write(answer.body if answer.cut is None else answer.body[: answer.cut])
                self.close_connection = answer.cut is not None

            do_GET = do_POST = do_PUT = do_PATCH = do_DELETE = handle_one

            def log_message(self, format: str, *arguments: Any) -> None:
                pass

        self.server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.server.daemon_threads = True
        self.url = f"http://127.0.0.1:{self.server.server_address[1]}"

    def next(self, received: Received) -> Answer:
        with self.lock:
            self.received.append(received)
            if callable(self.answers):
                return self.answers(received)
            return self.answers[min(len(self.received), len(self.answers)) - 1]

    def __enter__(self) -> Fake:
        threading.Thread(target=self.server.serve_forever, kwargs={"poll_interval": 0.02}, daemon=True).start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.server.shutdown()
        self.server.server_close()

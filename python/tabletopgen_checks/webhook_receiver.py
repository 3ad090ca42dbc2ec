"""A receiver of webhooks on a free port of this machine, which answers by a script and keeps what it gets.

The library of Standard Webhooks verifies the messages, in an environment of its own.
"""

import json
import subprocess
import threading
import time
from dataclasses import dataclass
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

from tabletopgen_checks.problem import Problem
from tabletopgen_checks.repository import JUDGES
from tabletopgen_checks.virtual_environment import environment_of

JUDGE = JUDGES / "webhooks"
# Longest silence of a receiver that does not answer, seconds.
MAX_SILENCE_S = 600
# Piece of a long answer.
PIECE_BYTES = 1 << 16


@dataclass
class Answer:
    """An answer to one request: a status after some silence, with a number of bytes and an address for redirects."""

    status: int = 204
    after_s: float = 0.0
    size_bytes: int = 0
    location: str = ""


@dataclass
class Received:
    """A message as it came."""

    headers: dict
    body: str
    at_s: float


class WebhookReceiver:
    """Answers requests by `answers` in their order, and then by 204. `received` has all of them."""

    def __init__(self, answers: "list | None" = None):
        self.answers: list = list(answers or [])
        self.received: list = []
        self._lock, self._ended = threading.Lock(), threading.Event()

    def __enter__(self):
        receiver = self

        class Handler(BaseHTTPRequestHandler):
            def do_POST(self):
                receiver.answer(self)

            def log_message(self, *_):
                """Silent: `received` has all of it."""

        self._server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self._server.daemon_threads = True
        self.port: int = self._server.server_address[1]
        threading.Thread(target=self._server.serve_forever, daemon=True).start()
        return self

    def __exit__(self, *_):
        self._ended.set()
        self._server.shutdown()
        self._server.server_close()

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.port}/hook"

    def settings(self, retry_secs: str = "0.1, 0.2, 0.4, 0.8, 1.6, 3.2", timeout_secs: int = 1) -> list:
        """Settings of a server that may send here, and tries again soon."""
        chosen = {"hosts": f"127.0.0.1:{self.port}", "retry_secs": retry_secs, "timeout_secs": str(timeout_secs)}
        return [part for key, value in chosen.items() for part in ("--set", f"webhooks.{key}={value}")]

    def answer(self, handler: BaseHTTPRequestHandler) -> None:
        body = handler.rfile.read(int(handler.headers.get("content-length", "0"))).decode()
        headers = {name.lower(): value for name, value in handler.headers.items()}
        with self._lock:
            self.received.append(Received(headers, body, time.time()))
            answer = self.answers.pop(0) if self.answers else Answer()
        self._ended.wait(min(answer.after_s, MAX_SILENCE_S))
        try:
            handler.send_response(answer.status)
            if answer.location:
                handler.send_header("location", answer.location)
            if answer.status != 204:
                handler.send_header("content-length", str(answer.size_bytes))
            handler.end_headers()
            for start in range(0, answer.size_bytes, PIECE_BYTES):
                handler.wfile.write(b"x" * min(PIECE_BYTES, answer.size_bytes - start))
        except OSError:
            # The sender has heard enough.
            handler.close_connection = True

    def wait(self, count: int, timeout_s: float = 60) -> list:
        """The messages, when so many are there."""
        deadline = time.monotonic() + timeout_s
        while len(self.received) < count:
            if time.monotonic() > deadline:
                raise Problem(f"{len(self.received)} of {count} messages came within {timeout_s} s")
            time.sleep(0.02)
        return list(self.received)


def verified(received: list, secret: str, target: Path) -> list:
    """What the library of Standard Webhooks reads in each message: its content, or `{"fault": ...}`."""
    python = environment_of(target, "webhooks-judge", JUDGE / "requirements.txt") / "bin" / "python"
    given = {"secret": secret, "messages": [{"headers": one.headers, "body": one.body} for one in received]}
    command = [str(python), str(JUDGE / "verify.py")]
    ended = subprocess.run(command, input=json.dumps(given), capture_output=True, text=True)
    if ended.returncode != 0:
        raise Problem(f"the judge of webhooks failed: {ended.stderr}")
    return [json.loads(line) for line in ended.stdout.splitlines()]

"""Runs the server for demo and bars, and speaks its HTTP. Standard library only.

Server is a context manager: the process is gone when the block ends, however it ends.
"""

import copy
import http.client
import json
import os
import re
import shutil
import signal
import socket
import subprocess
import threading
import time
import uuid
from pathlib import Path

from tabletopgen_checks.problem import Problem, end_of_log

# A cold start makes the database and checks the catalog; both take well under a second.
START_SECONDS = 60
STOP_SECONDS = 45
FULL_BYTES = 5_000_000
ENDED = ("job_succeeded", "job_failed", "job_cancelled")


class Server:
    """`tabletopgen serve` on a free port of this machine, its words in `log`.

    `role` is that of `--role`; `within` is a command that runs the server, such as `taskset -c 0`.
    """

    def __init__(self, binary: Path, data: Path, log: Path, environment=None, arguments=(), role=None, within=()):
        self.binary, self.data, self.log = Path(binary), Path(data), Path(log)
        self.environment, self.arguments = environment or {}, list(arguments)
        self.role, self.within = role, list(within)
        self.process: subprocess.Popen | None = None
        # 0 until it says where it listens.
        self.port = 0
        # The API key that requests state; none where it is empty.
        self.key = ""

    def __enter__(self):
        self.start()
        return self

    def __exit__(self, kind, *_):
        # After Ctrl-C stages are not waited for.
        self.stop(5 if kind is KeyboardInterrupt else STOP_SECONDS)

    def start(self):
        """Returns when the server takes work."""
        self.launch()
        self.wait_until_ready()

    def launch(self):
        """Starts the process and does not wait for it."""
        command = [*self.within, str(self.binary), "serve", "--listen", "127.0.0.1:0", "--data-dir", str(self.data)]
        command += ["--role", self.role] if self.role else []
        with open(self.log, "ab") as log:
            try:
                self.process = subprocess.Popen(
                    command + self.arguments,
                    stdin=subprocess.DEVNULL,
                    stdout=subprocess.PIPE,
                    stderr=log,
                    env=dict(os.environ, **self.environment),
                    # Ctrl-C reaches this script alone, which then stops the server in order.
                    start_new_session=True,
                )
            except OSError as error:
                raise Problem(f"{self.binary} does not start: {error.strerror}; build it with `make build`") from error
        self.port, self.announced = 0, threading.Event()
        threading.Thread(target=self._listen, args=(self.process.stdout, self.announced), daemon=True).start()

    def wait_until_ready(self):
        deadline = time.monotonic() + START_SECONDS
        try:
            self.wait_until_announced(deadline)
            while True:
                try:
                    if self.request("GET", "/readyz", timeout=5)[0] == 200:
                        return
                except Problem:
                    self._check_alive("before it was ready")
                if time.monotonic() > deadline:
                    raise Problem(f"the server was not ready within {START_SECONDS} s\n{self.words()}")
                time.sleep(0.02)
        except BaseException:
            self.kill()
            raise

    def wait_until_announced(self, deadline=None):
        """For a process whose port cannot be reached from here."""
        deadline = deadline or time.monotonic() + START_SECONDS
        while not self.announced.wait(0.05):
            self._check_alive("before it said where it listens")
            if time.monotonic() > deadline:
                raise Problem(f"the server did not say where it listens within {START_SECONDS} s\n{self.words()}")

    def _listen(self, stdout, announced):
        """Finds the address in the first lines, and keeps the pipe from filling up."""
        with open(self.log, "ab", buffering=0) as log:
            for line in stdout:
                log.write(line)
                found = re.search(rb"127\.0\.0\.1:(\d+)", line)
                if found and not announced.is_set():
                    self.port = int(found.group(1))
                    announced.set()

    def stop(self, patience=STOP_SECONDS):
        """Asks it to end (it drains first), then insists; it is gone afterwards in any case."""
        if self.process is None or self.process.poll() is not None:
            return
        try:
            self.process.send_signal(signal.SIGTERM)
            self.process.wait(patience)
        except subprocess.TimeoutExpired:
            self.kill()
            if patience == STOP_SECONDS:
                raise Problem(f"the server did not stop within {patience} s of SIGTERM and was killed\n{self.words()}") from None
        finally:
            self.kill()

    def kill(self):
        """kill -9, and waits until the process is gone."""
        if self.process is not None and self.process.poll() is None:
            self.process.kill()
            self.process.wait()

    @property
    def pid(self) -> int:
        assert self.process is not None, "the server was not launched"
        return self.process.pid

    def pause(self):
        """The process stops where it is, as a virtual machine does that is moved."""
        os.kill(self.pid, signal.SIGSTOP)

    def resume(self):
        os.kill(self.pid, signal.SIGCONT)

    def as_client(self, key: str) -> "Server":
        """The process, which runs, as one asks it who has this API key."""
        client = copy.copy(self)
        client.key = key
        return client

    def credential(self) -> dict:
        """The header that states the key."""
        return {"authorization": f"Bearer {self.key}"} if self.key else {}

    def words(self) -> str:
        """The end of its log."""
        return end_of_log(self.log, "the server")

    def _check_alive(self, when):
        code = self.process.poll() if self.process is not None else None
        if code is not None:
            how = f"by signal {signal.Signals(-code).name}" if code < 0 else f"with exit code {code}"
            raise Problem(f"the server ended {how} {when}\n{self.words()}")

    def _check_disk(self):
        """A server whose disk is full waits for room; this program does not wait with it."""
        # An interface alone may have made no folder yet.
        free = shutil.disk_usage(self.data if self.data.exists() else self.data.parent).free
        if free < FULL_BYTES:
            raise Problem(f"the disk of {self.data} is full ({free // 1000} kB left); free some space, or set TMPDIR")

    def request(self, method, path, body=None, headers=None, timeout=60):
        """(status, headers, bytes)."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=timeout)
        try:
            connection.request(method, path, body=body, headers={**self.credential(), **(headers or {})})
            response = connection.getresponse()
            return response.status, response.headers, response.read()
        except (OSError, http.client.HTTPException) as error:
            self._check_alive(f"while it was asked for {path}")
            raise Problem(f"{method} {path} on port {self.port} failed: {error or type(error).__name__}\n{self.words()}") from error
        finally:
            connection.close()

    def json(self, method, path, body=None, headers=None, expect=(200, 202)):
        """The answer's JSON; an answer that is an error is a Problem with the server's own words."""
        headers = dict(headers or {})
        if body is not None and not isinstance(body, bytes):
            body = json.dumps(body).encode()
            headers["content-type"] = "application/json"
        status, _, content = self.request(method, path, body, headers)
        if status not in expect:
            raise Problem(f"{method} {path} was answered with {status}: {refusal(content)}")
        return json.loads(content)

    def submit_text(self, text, seed=None, **more):
        return self.json("POST", "/scenes", dict({"text": text}, **({} if seed is None else {"seed": seed}), **more))

    def submit_image(self, content: bytes, seed=None):
        """As a browser's form would send it: bytes and nothing about them."""
        boundary = uuid.uuid4().hex
        parts = [(b'name="image"; filename="picture"', b"application/octet-stream", content)]
        if seed is not None:
            parts.append((b'name="request"', b"application/json", json.dumps({"seed": seed}).encode()))
        body = b"".join(
            b"--%s\r\nContent-Disposition: form-data; %s\r\nContent-Type: %s\r\n\r\n%s\r\n"
            % (boundary.encode(), name, kind, data)
            for name, kind, data in parts
        )
        body += b"--%s--\r\n" % boundary.encode()
        return self.json("POST", "/scenes", body, {"content-type": f"multipart/form-data; boundary={boundary}"})

    def events(self, job_id, after=0, deadline=None):
        """Every event of the job as it happens, until it has ended. A broken stream is picked up again."""
        while True:
            try:
                for event in self._stream(job_id, after, deadline):
                    after = event["seq"]
                    yield event
                    if event["kind"] in ENDED:
                        return
            except (OSError, http.client.HTTPException) as error:
                self._check_alive("while a job was running")
                if deadline is not None and time.monotonic() > deadline:
                    raise Problem(f"job {job_id} was not done in time\n{self.words()}") from error
                time.sleep(0.1)
            else:
                return

    def _stream(self, job_id, after, deadline):
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=20)
        try:
            headers = {"accept": "text/event-stream", "last-event-id": str(after), **self.credential()}
            connection.request("GET", f"/jobs/{job_id}/events", headers=headers)
            response = connection.getresponse()
            if response.status == 204:
                return
            if response.status != 200:
                raise Problem(f"the events of job {job_id} were refused: {refusal(response.read())}")
            data = []
            while line := response.readline():
                self._check_disk()
                if deadline is not None and time.monotonic() > deadline:
                    raise Problem(f"job {job_id} was not done in time\n{self.words()}")
                line = line.rstrip(b"\r\n")
                if line.startswith(b"data:"):
                    data.append(line[5:].strip())
                elif not line and data:
                    yield json.loads(b"\n".join(data))
                    data = []
            raise http.client.IncompleteRead(b"")
        finally:
            connection.close()

    def events_after(self, job_id, after=0) -> list:
        """Every event so far, page by page."""
        events = []
        while page := self.json("GET", f"/jobs/{job_id}/events?after={after}&page_size=200")["events"]:
            events += page
            after = page[-1]["seq"]
        return events

    def wait(self, job_id, seconds=600):
        """The job's row once it has ended."""
        for _ in self.events(job_id, deadline=time.monotonic() + seconds):
            pass
        return self.json("GET", f"/jobs/{job_id}")

    def download(self, path, target: Path):
        """Into a file, which appears only when it is complete."""
        status, _, content = self.request("GET", path, timeout=300)
        if status != 200:
            raise Problem(f"GET {path} was answered with {status}: {refusal(content)}")
        partial = target.with_name(target.name + ".part")
        partial.write_bytes(content)
        partial.replace(target)
        return content


def refusal(content: bytes) -> str:
    """What a problem document says."""
    try:
        problem = json.loads(content)
        places = [f"{e.get('pointer') or '/'}: {e.get('detail')}" for e in problem.get("errors", [])]
        return "; ".join([f"{problem.get('detail')} ({problem.get('code')})"] + places)
    except (ValueError, AttributeError):
        return content[:300].decode("utf-8", "replace") or "(no words)"


def loopback_works():
    """Fails early, and says so, where even 127.0.0.1 is closed to this process."""
    try:
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
    except OSError as error:
        raise Problem(f"no port of 127.0.0.1 can be opened here ({error.strerror}); allow loopback connections") from error

"""A server of this machine that lives as long as its client: the program of the wheel, or the one on PATH."""

from __future__ import annotations

import atexit
import os
import re
import shutil
import signal
import subprocess
import sysconfig
import tempfile
import threading
import time
from collections.abc import Mapping
from pathlib import Path

import httpx

from tabletopgen.errors import LocalServerError, ProgramMissingError

START_SECS = 60.0
STOP_SECS = 45.0
POLL_SECS = 0.02
ADDRESS = re.compile(r"listening on (http://127\.0\.0\.1:\d+)")
# Ends the server when standard input does: also after a client that was killed, none is left.
KEEPER = """
exec 3<&0
"$@" </dev/null 3<&- & server=$!
(cat <&3 >/dev/null; kill -TERM $server 2>/dev/null) >/dev/null 2>&1 & watch=$!
exec 3<&-
wait $server; code=$?
kill $watch 2>/dev/null
exit $code
"""


def program() -> Path:
    """The program `tabletopgen`: that of the wheel, else the first on PATH."""
    schemes = [sysconfig.get_path("scripts"), sysconfig.get_path("scripts", sysconfig.get_preferred_scheme("user"))]
    for folder in schemes:
        found = Path(folder) / "tabletopgen"
        if found.is_file() and os.access(found, os.X_OK):
            return found
    if on_path := shutil.which("tabletopgen"):
        return Path(on_path)
    raise ProgramMissingError(
        "no program `tabletopgen` was found. Install the wheel for this platform (pip install tabletopgen), or put the "
        "program on PATH; a client without it names a server: Client(url=...) or TABLETOPGEN_URL"
    )


class LocalServer:
    """`tabletopgen serve` on a free port of 127.0.0.1. Without a data directory it has a temporary one."""

    def __init__(self, data_dir: str | Path | None, settings: Mapping[str, object]):
        self.program = program()
        self.settings = settings
        self.temporary = tempfile.TemporaryDirectory(prefix="tabletopgen-")
        self.data_dir = Path(data_dir) if data_dir is not None else Path(self.temporary.name) / "data"
        self.log = Path(self.temporary.name) / "log"
        self.process: subprocess.Popen[str] | None = None
        self.url = ""
        self.starting = threading.Lock()

    def start(self) -> str:
        """The address of the server, which takes work. One that has ended is started again, on the same data."""
        with self.starting:
            if self.process is None or self.process.poll() is not None:
                self._end(0)
                self._launch()
            return self.url

    def _launch(self) -> None:
        deadline = time.monotonic() + START_SECS
        # The address stays the same.
        listen = self.url.removeprefix("http://") or "127.0.0.1:0"
        command = [str(self.program), "serve", "--listen", listen, "--data-dir", str(self.data_dir)]
        for name, value in self.settings.items():
            command += ["--set", f"{name}={value}"]
        with open(self.log, "ab") as log:
            self.process = subprocess.Popen(
                ["/bin/sh", "-c", KEEPER, "tabletopgen", *command],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=log,
                text=True,
                # Ctrl-C reaches the client alone, which then stops the server in order.
                start_new_session=True,
            )
        atexit.register(self.stop)
        announced = threading.Event()
        threading.Thread(target=self._listen, args=(self.process, announced), daemon=True).start()
        try:
            while not (announced.is_set() and self._is_ready()):
                if self.process.poll() is not None:
                    raise LocalServerError(f"{self.program} ended before it was ready:\n{self._end_of_log()}")
                if time.monotonic() > deadline:
                    raise LocalServerError(f"{self.program} was not ready within {START_SECS:.0f} s:\n{self._end_of_log()}")
                time.sleep(POLL_SECS)
        except BaseException:
            self._end(0)
            raise

    def _listen(self, process: subprocess.Popen[str], announced: threading.Event) -> None:
        """Finds the address in the first lines, and keeps the pipe from filling up."""
        assert process.stdout is not None
        with process.stdout as lines:
            for line in lines:
                if found := ADDRESS.search(line):
                    self.url = found[1]
                    announced.set()

    def _is_ready(self) -> bool:
        try:
            return httpx.get(f"{self.url}/readyz", timeout=5, trust_env=False).status_code == 200
        except httpx.TransportError:
            return False

    def _end_of_log(self) -> str:
        lines = self.log.read_text(encoding="utf-8", errors="replace").splitlines()[-15:]
        return "\n".join(f"  {line}" for line in lines or ["(nothing)"])

    def stop(self) -> None:
        """Lets running stages finish, and ends the server in any case."""
        atexit.unregister(self.stop)
        self._end(STOP_SECS)
        self.temporary.cleanup()

    def _end(self, patience_secs: float) -> None:
        """Ends the server and what keeps it, after a while by force."""
        if self.process is not None:
            assert self.process.stdin is not None
            self.process.stdin.close()
            try:
                self.process.wait(patience_secs)
            except subprocess.TimeoutExpired:
                os.killpg(self.process.pid, signal.SIGKILL)
                self.process.wait()

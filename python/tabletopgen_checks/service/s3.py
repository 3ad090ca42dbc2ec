"""Starts a private S3-compatible server for tests and bars: PyPI `moto`, loopback, a free port, objects in memory.

    PYTHONPATH=python python3 -m tabletopgen_checks.service.s3 [--target-dir target] COMMAND...

runs the command with the address in TABLETOPGEN_TEST_S3_URL and keys that the server takes. Standard library only.
"""

import contextlib
import http.client
import os
import re
import subprocess
import sys
import time
from pathlib import Path

from tabletopgen_checks.problem import Problem
from tabletopgen_checks.processes import run_beside
from tabletopgen_checks.service.postgres import free_port
from tabletopgen_checks.virtual_environment import environment_of

PIN = "moto[server]==5.2.5"
VARIABLE = "TABLETOPGEN_TEST_S3_URL"
REGION = "us-east-1"
START_SECONDS = 60
# moto answers 500 where an object goes while it lists; it is asked again so often.
LISTINGS = 10


class S3:
    """A server of its own, gone with all objects when the block ends."""

    def __init__(self, target: Path, log: Path, listen="127.0.0.1"):
        self.target, self.log, self.listen, self.process = Path(target), Path(log), listen, None

    def __enter__(self):
        program = environment_of(self.target, "s3", [PIN]) / "bin/moto_server"
        self.port = free_port()
        with open(self.log, "ab") as log:
            self.process = subprocess.Popen(
                [str(program), "-H", self.listen, "-p", str(self.port)],
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=log,
                start_new_session=True,
                # A line of log for every request would cost more than the request.
                env=dict(os.environ, PYTHONWARNINGS="ignore", **self.environment()),
            )
        deadline = time.monotonic() + START_SECONDS
        while True:
            try:
                self.request("GET", "/")
                return self
            except OSError:
                if self.process.poll() is not None or time.monotonic() > deadline:
                    self.__exit__()
                    raise Problem(f"{PIN} did not start; see {self.log}") from None
                time.sleep(0.1)

    def __exit__(self, *_):
        if self.process is not None and self.process.poll() is None:
            self.process.kill()
            self.process.wait()

    @property
    def host(self) -> str:
        return "127.0.0.1" if self.listen == "0.0.0.0" else self.listen

    def url(self) -> str:
        return f"http://{self.host}:{self.port}"

    def environment(self) -> dict:
        """Keys of a client; the server checks none."""
        return {"AWS_ACCESS_KEY_ID": "test", "AWS_SECRET_ACCESS_KEY": "test", "AWS_REGION": REGION}

    def settings(self, bucket: str, url=None) -> dict:
        """Settings of a tabletopgen that keeps its blobs here."""
        return {
            "store.blobs": "s3",
            "store.s3.endpoint": url or self.url(),
            "store.s3.bucket": bucket,
            "store.s3.region": REGION,
            "store.s3.path_style": "true",
            "store.s3.allow_http": "true",
        }

    def create(self, bucket: str):
        status, content = self.request("PUT", f"/{bucket}")
        if status not in (200, 409):
            raise Problem(f"the bucket {bucket} was not created: {status} {content[:200]!r}")

    def objects(self, bucket: str) -> dict:
        """Size by key."""
        found, token = {}, ""
        while True:
            for _ in range(LISTINGS):
                status, content = self.request("GET", f"/{bucket}?list-type=2&max-keys=1000{token}")
                if status < 500:
                    break
            if status != 200:
                raise Problem(f"the bucket {bucket} was not listed: {status}")
            text = content.decode()
            for entry in re.findall(r"<Contents>(.*?)</Contents>", text, re.DOTALL):
                ((key,), (size,)) = re.findall(r"<Key>(.*?)</Key>", entry), re.findall(r"<Size>(\d+)</Size>", entry)
                found[key] = int(size)
            more = re.search(r"<NextContinuationToken>(.*?)</NextContinuationToken>", text)
            if not more:
                return found
            token = f"&continuation-token={more[1]}"

    def request(self, method, path):
        connection = http.client.HTTPConnection(self.host, self.port, timeout=30)
        try:
            # moto routes by the service named in the signature; it checks nothing else of it.
            credential = f"Credential=test/20260101/{REGION}/s3/aws4_request, SignedHeaders=host, Signature=0"
            connection.request(method, path, headers={"authorization": f"AWS4-HMAC-SHA256 {credential}"})
            response = connection.getresponse()
            return response.status, response.read()
        except http.client.HTTPException as error:
            raise OSError(str(error)) from error
        finally:
            connection.close()


@contextlib.contextmanager
def environment(target: Path):
    """The variables that lead a command to a server of its own."""
    target.mkdir(parents=True, exist_ok=True)
    with S3(target, target / "s3.log") as server:
        yield server.environment() | {VARIABLE: server.url()}


if __name__ == "__main__":
    sys.exit(run_beside("Run a command beside a private S3 server.", environment))

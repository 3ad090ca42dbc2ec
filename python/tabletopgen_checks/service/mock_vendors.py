"""The mock vendors of the lab: a server that speaks the protocols of all remote models."""

import http.client
import json
import re
import subprocess
from pathlib import Path

from tabletopgen_checks.problem import Problem
from tabletopgen_checks.repository import lab_beside

# Decides what they answer.
SEED = 7


class MockVendors:
    """`tabletopgen-lab mock-vendors`, of the same build as `binary`, on a free port or another address, and its
    bill."""

    def __init__(self, binary: Path, latency_ms: int = 0, listen: str = "127.0.0.1:0"):
        self.lab, self.latency_ms, self.listen = lab_beside(binary), latency_ms, listen

    def __enter__(self):
        command = [self.lab, "mock-vendors", "--listen", self.listen, "--seed", str(SEED)]
        command += ["--latency-ms", str(self.latency_ms)]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, start_new_session=True)
        assert self.process.stdout is not None
        found = re.search(r"127\.0\.0\.1:(\d+)", self.process.stdout.readline())
        if not found:
            raise Problem("mock-vendors did not say where it listens")
        self.port = int(found[1])
        return self

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait(60)

    def settings(self) -> list:
        # A killed worker's job is taken over at once, and as often as it takes.
        chosen = self.vendors() | {"worker.poll_ms": "20", "worker.max_attempts": "50"}
        return [part for key, value in chosen.items() for part in ("--set", f"{key}={value}")]

    def vendors(self) -> dict:
        """Settings that ask this server for everything."""
        base = f"http://127.0.0.1:{self.port}"
        chosen = {
            "analyst": "chat, embedded",
            "image_generator": "openai_images, embedded",
            "segmenter": "sidecar",
            "mesh_generator": "replicate, embedded",
            "allow_http": "true",
            "private_hosts": "127.0.0.1",
            "on_unknown": "resend",
            "chat.base_url": base + "/v1",
            "openai_images.base_url": base + "/v1",
            "openai_images.calls_per_minute": "1000000",
            "segmenter_sidecar.base_url": base,
            "segmenter_sidecar.usd_per_call": "0.001",
            "replicate.base_url": base + "/v1",
            "replicate.poll_interval_ms": "50",
        }
        return {f"providers.{key}": value for key, value in chosen.items()} | {"server.usual_budget_usd": "1000"}

    def bill(self) -> list:
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=30)
        connection.request("GET", "/bill")
        lines = json.loads(connection.getresponse().read())
        connection.close()
        return [(line["protocol"], line["operation"], line["request_sha256"]) for line in lines]

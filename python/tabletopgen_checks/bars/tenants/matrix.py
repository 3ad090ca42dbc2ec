"""Every operation of the contract with every credential that must not open it, on both stores.

The requests are those of tests/it/api/access.rs, which reads the operations from the contract: this part runs the tests
and reads what they counted."""

import os
import re
import subprocess

from tabletopgen_checks.bars.reliability.bench import STORES
from tabletopgen_checks.bars.reliability.part import Finding
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.repository import ROOT
from tabletopgen_checks.service import postgres

COUNTED = re.compile(r"^matrix: (.+): (\d+) requests of (\d+) operations, (\d+) changes$", re.MULTILINE)
# Kinds of requests that the tests count.
KINDS = (
    "without a key",
    "with a wrong key",
    "with a foreign key",
    "with a password",
    "with an expired key",
    "with a revoked key",
    "with a wrong cookie",
    "without the scope",
    "of a page of another site",
    "about what another tenant has",
)


def measure(bench) -> Finding:
    rows, wrong = [], []
    for store in bench.stores():
        counted = {what: counts for what, *counts in COUNTED.findall(run_tests(bench, store))}
        wrong += [f"{store}: nothing was counted {what}" for what in KINDS if what not in counted]
        for what, (requests, operations, changes) in counted.items():
            rows.append([store, what, operations, requests, 0, changes])
    held = not wrong and all(int(row[-1]) == 0 for row in rows)
    columns = ["store", "requests", "operations", "sent", "answered with anything but the refusal", "changes"]
    words = (
        "The first difference ends the test, and so this part: a refusal of another code, or lists of the tenant that have "
        "changed after the requests. About what another tenant has is asked twice, for JSON and for an event stream."
    )
    return Finding(columns, rows, held, "\n\n".join([words, *wrong]), full=len(bench.stores()) == len(STORES))


def run_tests(bench, store: str) -> str:
    """What the tests of access print."""
    command = [os.environ.get("CARGO", "cargo"), "test", "--workspace", "--locked", "--test", "it", "--", "api::access", "--nocapture"]
    variables = {"CARGO_TARGET_DIR": str(bench.given.target_dir)}
    if store == "postgres":
        variables |= {"TABLETOPGEN_TEST_DATABASE": "postgres", postgres.VARIABLE: bench.postgres.url()}
    done = subprocess.run(command, cwd=ROOT, env=os.environ | variables, capture_output=True, text=True)
    if done.returncode != 0:
        raise Problem(f"the tests of access fail on {store}:\n{(done.stdout + done.stderr)[-3000:]}")
    return done.stdout + done.stderr

"""The guarantees of the service under failures, on both stores.

    PYTHONPATH=python python3 -m tabletopgen_checks.bars.reliability [--target-dir target] [--only kills,pauses] \\
        [--kills 50] ...

Each part measures one promise with a count that can be made smaller. What it finds is kept in
docs/results/reliability.json with the command and the commit, and the page docs/results/reliability.md is made of all
parts that were measured so far; `--page no` leaves both as they are. `--program` names another binary, with
tabletopgen-lab beside it."""

import json
import shlex
import signal
import sys
import time
from pathlib import Path

from tabletopgen_checks.bars.page import arguments, machine, measured_commit, table
from tabletopgen_checks.bars.reliability import DEPENDS_ON, churn, faults, kills, kinds, leases, single, soak, submits, throughput
from tabletopgen_checks.bars.reliability.bench import STORES, Bench
from tabletopgen_checks.bars.reliability.part import yes
from tabletopgen_checks.bars.run import run
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.repository import RESULTS
from tabletopgen_checks.result_pages import dependency_line

PARTS = {
    "kills": ("Killed at every stage boundary and under load", kills.measure),
    "kinds": ("Killed across all kinds of jobs", kinds.measure),
    "pauses": ("Stopped past the lease, then continued", leases.measure_pauses),
    "reclaims": ("From a kill to the next claim", leases.measure_reclaims),
    "slow_stage": ("A stage that is longer than the lease", leases.measure_slow_stage),
    "twins": ("The same request twice at once", single.measure_twins),
    "posts": ("Identical POSTs at once", single.measure_posts),
    "vendors": ("Scenes per hour against slow vendors", throughput.measure_vendors),
    "cores": ("Embedded models on one core and on two", throughput.measure_cores),
    "submits": ("Durable submissions", submits.measure),
    "faults": ("Restarts, outages, a cut, a full disk", faults.measure),
    "churn": ("Created and deleted", churn.measure),
    "soak": ("Steady work", soak.measure),
}
# The promised counts are the defaults.
OPTIONS = {
    "kills": kills.PROMISED,
    "kind_kills": kinds.PROMISED,
    "kind_seed": kinds.SEED,
    "pauses": leases.PROMISED_PAUSES,
    "reclaims": leases.PROMISED_RECLAIMS,
    "lease": leases.DEFAULT_LEASE_SECONDS,
    "stage_seconds": leases.PROMISED_STAGE_SECONDS,
    "twins": single.PROMISED_TWINS,
    "posts": single.PROMISED_POSTS,
    "workers": max(throughput.WORKERS),
    "scenes_each": throughput.PROMISED_SCENES,
    "latency_ms": 4000,
    "embedded_each": throughput.PROMISED_EMBEDDED,
    "submit_seconds": submits.PROMISED_SECONDS,
    "outage_seconds": faults.PROMISED_OUTAGE_SECONDS,
    "churn": churn.PROMISED,
    "soak_minutes": float(soak.PROMISED_MINUTES),
}
KEPT = RESULTS / "reliability.json"


def main() -> bool:
    given = arguments(
        __doc__,
        only=",".join(PARTS),
        stores=",".join(STORES),
        program="",
        page="yes",
        keep="",
        **OPTIONS,
    )
    if given.program:
        given.binary = Path(given.program).resolve()
    chosen = given.only.replace(",", " ").split()
    if unknown := [name for name in chosen if name not in PARTS]:
        raise Problem(f"there is no part {', '.join(unknown)}; parts are {', '.join(PARTS)}")
    command = command_of(sys.argv[1:])
    # What was started is stopped also where this program is ended.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    held, failed = True, []
    with Bench(given) as bench:
        for name in chosen:
            title, measure = PARTS[name]
            print(f"== {name}: {title}", flush=True)
            began = time.monotonic()
            try:
                found = measure(bench)
            except Problem as problem:
                # The other parts are of use all the same.
                print(f"== {name} could not be measured: {problem}", flush=True)
                failed.append(name)
                continue
            took = time.monotonic() - began
            print(
                f"{table(found.columns, found.rows)}\n\n{found.words}\n== {name} {yes(found.held)} ({took:.0f} s)",
                flush=True,
            )
            held &= found.held
            if given.page == "yes":
                keep(name, found, command, took)
    if failed:
        raise Problem(f"not measured: {', '.join(failed)}; see above")
    return held


def command_of(words: list) -> str:
    """Without the options that only name places of this machine."""
    pairs = list(zip(words[::2], words[1::2]))
    options = " ".join(
        f"{name} {value}" for name, value in pairs if name not in ("--target-dir", "--program", "--keep")
    )
    return "make bars BARS=reliability" + (f" BARS_OPTIONS={shlex.quote(options)}" if options else "")


def keep(name, found, command, seconds):
    """Remembers the finding and writes the page anew."""
    known = json.loads(KEPT.read_text(encoding="utf-8")) if KEPT.exists() else {}
    known[name] = {
        "command": command,
        "commit": measured_commit(),
        "day": time.strftime("%Y-%m-%d", time.gmtime()),
        "machine": machine(),
        "minutes": round(seconds / 60, 1),
        "columns": found.columns,
        "rows": found.rows,
        "held": found.held,
        "full": found.full,
        "words": found.words,
        "plots": found.plots,
    }
    RESULTS.mkdir(parents=True, exist_ok=True)
    KEPT.write_text(json.dumps(known, indent=1) + "\n", encoding="utf-8")
    (RESULTS / "reliability.md").write_text(page_of(known), encoding="utf-8")


def page_of(known: dict) -> str:
    """The page of all parts measured so far."""
    rows = []
    for name, (title, _) in PARTS.items():
        part = known.get(name)
        counts = "-" if part is None else "promised counts" if part["full"] else "smaller counts"
        rows.append([title, "not measured" if part is None else yes(part["held"]), counts])
    pieces = [
        "# Reliability",
        "Written by `make bars BARS=reliability`; each section names its command and commit. Scenes are of one or two "
        "objects, with previews of the smallest size but in the part about cores. On PostgreSQL blobs are in S3, a private "
        "`moto` server; on SQLite they are files.",
        table(["part", "result", "measured with"], rows),
    ]
    for name, (title, _measure) in PARTS.items():
        part = known.get(name)
        if part is None:
            continue
        made = f"`{part['command']}` at commit {part['commit']} on {part['day']}, {part['machine']}"
        made += f", {part['minutes']} min."
        pieces += [f"## {title}", made, table(part["columns"], part["rows"]), part["words"]]
        pieces += [f"![{title}]({plot})" for plot in part["plots"]]
    pieces.append(dependency_line(DEPENDS_ON))
    return "\n\n".join(piece for piece in pieces if piece) + "\n"


if __name__ == "__main__":
    run(main)

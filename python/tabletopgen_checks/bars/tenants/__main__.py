"""Keys and tenants, on both stores.

    PYTHONPATH=python python3 -m tabletopgen_checks.bars.tenants [--target-dir target] [--only soak,deletion] \\
        [--scenes 1000] ...

Each part is a section of docs/results/tenants.md, written when it is measured; `--page no` leaves the page as it is.
`--program` names another binary. Secrets are searched for in what the parts before left, so that part comes last."""

import signal
import time
from pathlib import Path

from tabletopgen_checks.bars import contract
from tabletopgen_checks.bars.page import arguments, table, write_section
from tabletopgen_checks.bars.reliability.bench import STORES
from tabletopgen_checks.bars.reliability.part import yes
from tabletopgen_checks.bars.run import run
from tabletopgen_checks.bars.tenants import DEPENDS_ON, browser, deletion, fuzzing, key_cost, matrix, soak, traces, webhooks
from tabletopgen_checks.bars.tenants.bench import TenantBench
from tabletopgen_checks.problem import Problem

PARTS = {
    "matrix": ("Wrong credentials at every operation", matrix.measure),
    "soak": ("Two tenants, one of them hostile", soak.measure),
    "deletion": ("What deletion leaves", deletion.measure),
    "cost": ("What a key costs", key_cost.measure),
    "fuzzing": ("The contract with keys", fuzzing.measure),
    "webhooks": ("Receivers of webhooks that misbehave", webhooks.measure),
    "browser": ("Pages of other origins", browser.measure),
    "secrets": ("Where secrets go", traces.measure),
}
# The promised counts are the defaults.
OPTIONS = {
    "soak_seconds": soak.PROMISED_SECONDS,
    "scenes": deletion.PROMISED_SCENES,
    "others": deletion.PROMISED_OTHERS,
    "grace_seconds": deletion.PROMISED_GRACE_SECONDS,
    "turn_seconds": key_cost.PROMISED_TURN_SECONDS,
    "examples": contract.FULL_EXAMPLES,
    "fuzz_seed": 1,
}


def main() -> bool:
    given = arguments(__doc__, only=",".join(PARTS), stores=",".join(STORES), program="", page="yes", keep="", **OPTIONS)
    if given.program:
        given.binary = Path(given.program).resolve()
    chosen = given.only.replace(",", " ").split()
    if unknown := [name for name in chosen if name not in PARTS]:
        raise Problem(f"there is no part {', '.join(unknown)}; parts are {', '.join(PARTS)}")
    # What was started is stopped also where this program is ended.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    held, failed = True, []
    with TenantBench(given) as bench:
        for name in sorted(chosen, key=list(PARTS).index):
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
            counts = "the promised counts" if found.full else "smaller counts than promised"
            verdict = f"**{yes(found.held)}**, measured with {counts} in {(time.monotonic() - began) / 60:.1f} min."
            body = "\n\n".join([verdict, table(found.columns, found.rows), found.words])
            held &= found.held
            if given.page == "yes":
                write_section("tenants", title, body, DEPENDS_ON)
            else:
                print(body, flush=True)
    if failed:
        raise Problem(f"not measured: {', '.join(failed)}; see above")
    return held


if __name__ == "__main__":
    run(main)

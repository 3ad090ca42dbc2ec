"""Runs every judge over unpacked bundles and prints a table.

    target/judges/bin/python tests/judges/judge.py BUNDLE_DIR... [--json] [--only usd,mjcf] [--dss-bar 0.95]
        [--slow-seconds 0.5]

Exits with 1 if any judge rejects a bundle, or if fewer than the bar of all movable bodies (over all
bundles together) stay in place in MuJoCo; with 2 on wrong use. A judge that this Python has no packages for is
left out, and named.
"""

import argparse
import importlib
import json
import sys
import time
import traceback
from pathlib import Path

from left_out import LEFT_OUT
from verdict import Verdict

JUDGES = ["schema", "report", "usd", "robotics_prop", "mjcf", "urdf", "bullet", "sdf", "glb", "marks", "collisions", "readme"]
# They simulate scenes in Drake and PyBullet, which take up to a minute of CPU for a second. Rest is not promised there,
# so a few steps show whether the scene can be simulated; `bars/rest.py` measures five seconds.
SLOW = ("sdf", "bullet")


def main() -> int:
    parser = argparse.ArgumentParser(description="Let independent programs judge unpacked bundles.")
    parser.add_argument("bundles", nargs="+", type=Path, metavar="BUNDLE_DIR")
    parser.add_argument("--json", action="store_true", help="print machine-readable findings")
    parser.add_argument("--only", default=",".join(JUDGES), help="comma-separated judges")
    parser.add_argument("--dss-bar", type=float, default=0.95, help="share of movable bodies that must stay")
    parser.add_argument("--slow-seconds", type=float, default=0.5, help="how long each of SLOW simulates a scene")
    arguments = parser.parse_args()
    chosen = arguments.only.split(",")
    unknown = [name for name in chosen if name not in JUDGES]
    absent = [str(bundle) for bundle in arguments.bundles if not (bundle / "scene.json").is_file()]
    if unknown or absent:
        print(f"unknown judges {unknown}; no bundle at {absent}", file=sys.stderr)
        return 2
    left_out = {name: LEFT_OUT[name] for name in chosen if name in LEFT_OUT}
    chosen = [name for name in chosen if name not in left_out]
    modules = {name: importlib.import_module(name) for name in chosen}
    findings = {}
    for bundle in arguments.bundles:
        bundle = bundle.resolve()
        findings[str(bundle)] = [judged(modules[name], name, bundle, arguments) for name in chosen]

    settled = [v.facts for verdicts in findings.values() for v in verdicts if v.judge == "mjcf" and "movable" in v.facts]
    movable, stable = sum(f["movable"] for f in settled), sum(f["stable"] for f in settled)
    dss = stable / movable if movable else 1.0
    rejected = [v for verdicts in findings.values() for v in verdicts if not v.accepted]
    accepted = not rejected and dss >= arguments.dss_bar
    if arguments.json:
        print(
            json.dumps(
                {
                    "accepted": accepted,
                    "dss_mujoco": dss,
                    "left_out": left_out,
                    "bundles": {
                        bundle: {
                            v.judge: {"accepted": v.accepted, "complaints": v.complaints, "facts": v.facts}
                            for v in verdicts
                        }
                        for bundle, verdicts in findings.items()
                    },
                },
                indent=2,
            )
        )
    else:
        print_table(findings, dss, arguments.dss_bar, movable)
        for name, reason in left_out.items():
            print(f"left out: {name} ({reason})")
    return 0 if accepted else 1


def judged(module, name, bundle, arguments) -> Verdict:
    more = {"duration_s": arguments.slow_seconds} if name in SLOW else {}
    start = time.perf_counter()
    try:
        verdict = module.judge(bundle, **more)
    except Exception as error:  # whatever a judge trips over counts against the bundle, with its trace
        verdict = Verdict(name, [f"{error!r}: {traceback.format_exc(limit=-2)}"])
    verdict.facts["seconds"] = round(time.perf_counter() - start, 2)
    return verdict


def print_table(findings, dss, bar, movable):
    for bundle, verdicts in findings.items():
        print(bundle)
        for verdict in verdicts:
            facts = ", ".join(f"{key} {value}" for key, value in verdict.facts.items() if value != {})
            print(f"  {verdict.judge:<13} {'accepts' if verdict.accepted else 'REJECTS'}  {facts}")
            for complaint in verdict.complaints[:8]:
                print(f"    - {complaint}")
            if len(verdict.complaints) > 8:
                print(f"    - and {len(verdict.complaints) - 8} more")
    if movable:
        print(f"in MuJoCo {100 * dss:.1f} % of {movable} movable bodies stay in place (bar {100 * bar:.0f} %)")


if __name__ == "__main__":
    sys.exit(main())

"""NVIDIA's judges: every prop meets SimReady Robotics-Prop 4.0.0; their own rules find no error in any USD file.

`simready-validate` judges the props by the tier it finds installed. The rules of `usd-validation-nvidia` run in a
process of their own and without those that the tier adds, which are for robots. Props in a package are only judged by
the rules: the profile is about folders. Where text was asked for, the rule that prefers the crate format is not asked.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

from verdict import Verdict, bodies, read_scene

PROFILE, VERSION = "Robotics-Prop", "4.0.0"
# Core, minimal, rigid bodies, appearance, packaging and names; all that the profile does not call optional.
REQUIRED = [
    "FET_000_STANDARD", "FET_001_STANDARD", "FET_003_STANDARD", "FET_006_STANDARD", "FET_011_STANDARD",
    "FET_011_RTX", "FET_031_STANDARD", "FET_033_STANDARD", "FET_046_STANDARD",
]
RULES = 49
PREFERS_CRATE = "UsdAsciiPerformanceChecker"


def judge(bundle: Path) -> Verdict:
    verdict = Verdict("robotics_prop")
    props = sorted((bundle / "usd" / "assets").glob("*/simready_usd/*.usd*"))
    stages = sorted((bundle / "usd").glob("scene.usd*"))
    wanted = 0 if stages and stages[0].suffix == ".usdz" else len(bodies(read_scene(bundle)))
    if len(props) != wanted:
        verdict.complaints.append(f"{len(props)} props for {wanted} bodies")
    features = profiled(props) if props else {}
    refused = 0
    for path in props:
        lacking = lacks(features.get(str(path), {}))
        refused += bool(lacking)
        verdict.complaints += [f"{path.stem}: {words}" for words in lacking]
    optional = sorted({
        name
        for name in next(iter(features.values()), {})
        if name not in REQUIRED and all(found[name]["passed"] for found in features.values() if name in found)
    })
    outcome = ruled([*stages, *props])
    if outcome["rules"] < RULES:
        verdict.complaints.append(f"only {outcome['rules']} rules ran")
    if any(path.suffix == ".usda" for path in props):
        outcome["errors"] = [words for words in outcome["errors"] if PREFERS_CRATE not in words]
    verdict.complaints += outcome["errors"]
    verdict.facts = {
        "assets": len(props),
        "refused": refused,
        "optional": " ".join(optional),
        "files": len(stages) + len(props),
        "rules": outcome["rules"],
        "rule_errors": len(outcome["errors"]),
        "rule_warnings": outcome["warnings"],
    }
    return verdict


def profiled(props) -> dict:
    """Path to features, of simready-validate."""
    with tempfile.TemporaryDirectory() as folder:
        listed, found = Path(folder) / "list.txt", Path(folder) / "found.json"
        listed.write_text("".join(f"{path}\n" for path in props), encoding="utf-8")
        command = [Path(sys.executable).with_name("simready-validate"), "--profile", PROFILE, "--version", VERSION]
        command += ["--output", found, "--asset_list", listed]
        run = subprocess.run([str(part) for part in command], capture_output=True, text=True, timeout=600)
        if not found.is_file():
            raise RuntimeError(f"simready-validate did not run: {(run.stderr or run.stdout).strip()[-1000:]}")
        documents = json.loads(found.read_text(encoding="utf-8"))
    return {path: document["features_summary"] for path, document in documents.items() if "features_summary" in document}


def lacks(features) -> list:
    """What a prop fails in; a prop without features was not judged."""
    lacking = [f"{name} is not judged" for name in REQUIRED if name not in features]
    for name, feature in features.items():
        if feature.get("blocking_failure") or (name in REQUIRED and not feature["passed"]):
            lacking.append(f"{name} fails: {feature.get('failing requirements')} {feature.get('requirement_messages', '')}"[:400])
    return lacking


def ruled(files) -> dict:
    run = subprocess.run([sys.executable, __file__, *map(str, files)], capture_output=True, text=True, timeout=600)
    if run.returncode != 0:
        raise RuntimeError(f"NVIDIA's rules did not run: {run.stderr.strip()[-1000:]}")
    return json.loads(run.stdout.splitlines()[-1])


def rule_here(files) -> dict:
    import usd_validation_nvidia as nvidia

    registered = nvidia.CategoryRuleRegistry().rules
    own = [rule for rule in registered if rule.__module__.startswith("usd_validation_nvidia.")]

    def engine(variants):
        made = nvidia.ValidationEngine(init_rules=False, variants=variants)
        for rule in own:
            made.enable_rule(rule)
        return made

    # Variants belong to the props, which are judged one by one.
    stages, props = engine(variants=False), engine(variants=True)
    errors, warnings = [], 0
    for path in files:
        judged_by = stages if Path(path).stem == "scene" else props
        for issue in judged_by.validate(path):
            severity = issue.severity.name
            if severity in ("ERROR", "FAILURE"):
                errors.append(f"{Path(path).name}: {issue.rule.__name__}: {issue.message} ({issue.at})"[:300])
            warnings += severity == "WARNING"
    return {"rules": len(own), "errors": errors, "warnings": warnings}


if __name__ == "__main__":
    print(json.dumps(rule_here(sys.argv[1:])))

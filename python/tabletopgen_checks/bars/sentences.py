"""The sentences: everything asked for is there, nothing collides, everything stands, every judge accepts.

    PYTHONPATH=python python3 -m tabletopgen_checks.bars.sentences [--target-dir target]
"""

import json

from tabletopgen_checks.bars.page import SCENES_OF_TEXTS, arguments, percent, table, write
from tabletopgen_checks.bars.run import run
from tabletopgen_checks.judges.judging import complaints, finish_setup, judge, start_setup
from tabletopgen_checks.language.sentences import sentences
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.scene.generation import generate
from tabletopgen_checks.scene.scene import read_scene

DEPENDS_ON = (
    *SCENES_OF_TEXTS, "python/tabletopgen_checks/scene/relations.py", "tests/judges/bullet.py",
    "tests/judges/collisions.py", "tests/judges/mjcf.py", "tests/judges/usd.py", "tests/words/scenes.toml",
)


def main() -> bool:
    given = arguments(__doc__)
    environment = given.target_dir / "judges"
    finish_setup(start_setup(environment))
    rows, notes, failures = [], [], 0
    movable = stable = 0
    for sentence in sentences():
        print(f"{sentence.name} ...", flush=True)
        try:
            made = generate(given.binary, given.work / "sentences" / sentence.name, sentence.text, sentence.seed)
        except Problem as problem:
            rows.append([sentence.name, sentence.objects, "no scene"] + ["-"] * 7)
            notes.append(f"- {sentence.name}: {str(problem).splitlines()[-1].strip()}")
            failures += 1
            continue
        missing = sentence.complaints(read_scene(made.folder))
        findings = judge(environment, [made.folder], dss_bar=0.0)
        said = complaints(findings, made.folder)
        verdicts = findings["bundles"][str(made.folder.resolve())]
        facts = verdicts["mjcf"]["facts"]
        movable, stable = movable + facts.get("movable", sentence.objects), stable + facts.get("stable", 0)
        metrics = json.loads((made.folder / "scene.json").read_text(encoding="utf-8"))["metrics"]
        rows.append([
            sentence.name,
            sentence.objects,
            "all there" if not missing else "; ".join(missing),
            percent(metrics["col_s"]),
            percent(metrics["ss"]),
            percent(metrics["dss_aligned"]),
            percent(metrics["dss_shipped"]),
            percent(facts.get("stable", 0) / (facts.get("movable") or sentence.objects)),
            "all accept" if not said else f"{len(said)} complaints",
            f"{made.seconds:.1f}",
        ])
        if missing or said or metrics["col_s"] > 0 or metrics["ss"] < 1 or metrics["dss_shipped"] < 1:
            failures += 1
        notes += [f"- {sentence.name}: {words}" for words in made.printed["reasons"] + said[:10]]
        notes += [f"- {sentence.name}: in MuJoCo {name} moves {moved[0]} mm and turns {moved[1]} degrees"
                  for name, moved in facts.get("unstable", {}).items()]
    share = stable / movable if movable else 0.0
    columns = ["sentence", "objects", "requested", "Col_S", "SS", "DSS aligned", "DSS shipped", "at rest in MuJoCo",
               "judges", "seconds"]
    asked = "\n".join(f"- {s.name} (seed {s.seed}): {s.text}" for s in sentences())
    body = (
        f"{len(rows) - failures} of {len(rows)} sentences keep every promise; over all of them, {percent(share)} of "
        f"{movable} movable bodies are where they were after 5 s in MuJoCo (the bar is 95 %).\n\n"
        + table(columns, rows) + ("\n\n" + "\n".join(notes) if notes else "") + f"\n\nThe sentences:\n\n{asked}"
    )
    write("sentences", "The sentences of tests/words/scenes.toml", body, DEPENDS_ON)
    return failures == 0 and share >= 0.95


if __name__ == "__main__":
    run(main)

"""The same request and seed: the same bytes, with any number of threads, anywhere, on another day.

    PYTHONPATH=python python3 -m tabletopgen_checks.bars.determinism [--target-dir target]

docs/results/fingerprints.json keeps the digest of each run's bundle with the digest of the sources that
made it, so that a run on another day over the same sources is compared with the earlier ones.
"""

import json
import time

from tabletopgen_checks.bars.page import SCENES_OF_TEXTS, arguments, machine, source_digest, table, write
from tabletopgen_checks.bars.run import run
from tabletopgen_checks.language.sentences import sentences
from tabletopgen_checks.repository import RESULTS
from tabletopgen_checks.scene.generation import differing_files, fingerprint, generate

DEPENDS_ON = (*SCENES_OF_TEXTS, "crates/base/imaging", "crates/base/mesh_io", "crates/base/runtime")
SENTENCES = ("breakfast_bowl", "hobby_models")
CASES = [
    ("as it comes", None, {}),
    ("again", None, {}),
    ("1 thread", 1, {}),
    ("2 threads", 2, {}),
    ("8 threads", 8, {}),
    ("Pacific/Auckland, Turkish", None, {"TZ": "Pacific/Auckland", "LANG": "tr_TR.UTF-8", "LC_ALL": "tr_TR.UTF-8"}),
    ("America/St_Johns, no locale", 1, {"TZ": "America/St_Johns", "LANG": "C", "LC_ALL": "C"}),
]


def main() -> bool:
    given = arguments(__doc__)
    today, source = time.strftime("%Y-%m-%d", time.gmtime()), source_digest()
    history_path = RESULTS / "fingerprints.json"
    history = json.loads(history_path.read_text()) if history_path.is_file() else []
    rows, notes, held = [], [], True
    for sentence in (s for s in sentences() if s.name in SENTENCES):
        first = given.work / "determinism" / "first"
        for k, (case, threads, environment) in enumerate(CASES):
            folder = first if k == 0 else given.work / "determinism" / "other"
            generate(given.binary, folder, sentence.text, sentence.seed, threads, environment)
            differing = [] if k == 0 else differing_files(first, folder)
            held &= not differing
            print(f"{sentence.name}, {case}: {'same' if not differing else differing[:5]}", flush=True)
            rows.append([sentence.name, case, "same bytes" if not differing else f"{len(differing)} files differ"])
            notes += [f"- {sentence.name}, {case}: {name} differs" for name in differing[:10]]
        digest = fingerprint(first)
        earlier = [e for e in history if e["sentence"] == sentence.name and e["source"] == source]
        for entry in earlier:
            same = entry["bundle"] == digest
            held &= same
            rows.append([sentence.name, f"against {entry['day']}, {entry['machine']}", "same bytes" if same else "OTHER BYTES"])
        rows.append([sentence.name, "sha256 of the bundle", f"`{digest}`"])
        entry = {"sentence": sentence.name, "source": source, "day": today, "machine": machine(), "bundle": digest}
        if entry not in history:
            history.append(entry)
    history_path.parent.mkdir(parents=True, exist_ok=True)
    history_path.write_text(json.dumps(history, indent=1) + "\n")
    body = f"Digest of the sources: `{source}`.\n\n" + table(["sentence", "case", "result"], rows)
    write("determinism", "Same request, same bytes", body + ("\n\n" + "\n".join(notes) if notes else ""), DEPENDS_ON)
    return held


if __name__ == "__main__":
    run(main)

"""Tasks as files, read by the parser of BEHAVIOR (PyPI bddl) and checked against the JSON schema (PyPI jsonschema).

    python check_bddl.py FOLDER [SCHEMA]

FOLDER holds `domain.bddl` and, for each task, `NAME.bddl` and `NAME.json`, as `tabletopgen tasks --out` writes them;
`tabletopgen_checks.bars.robot` asks for each scene. Exits with 1 if the parser or the schema refuses a file, or if a
file states something else than the task.
"""

import json
import sys
from pathlib import Path

from bddl.parsing import parse_predicates, parse_problem, scan_tokens
from jsonschema import Draft202012Validator

DOMAIN = "tabletopgen"
NEGATED = {"out_of": "inside", "off": "ontop", "closed": "open"}
RENAMED = {"in": "inside", "on": "ontop", "next_to": "nextto", "opened": "open"}
SCHEMA = Path(__file__).parents[3] / "schemas" / "task.schema.json"


def main(folder, schema=SCHEMA):
    folder = Path(folder)
    validator = Draft202012Validator(json.loads(Path(schema).read_text()))
    arities = declared_arities((folder / "domain.bddl").read_text())
    problems = [path for path in sorted(folder.glob("*.bddl")) if path.name != "domain.bddl"]
    complaints = []
    for path in problems:
        task = json.loads(path.with_suffix(".json").read_text())
        complaints += [f"{path.stem}: {error.message}" for error in validator.iter_errors(task)]
        complaints += [f"{path.stem}: {complaint}" for complaint in judge(path.read_text(), task, arities)]
    print(json.dumps({"problems": len(problems), "complaints": complaints}, indent=1))
    return 1 if complaints or not problems else 0


def declared_arities(text):
    tokens = scan_tokens(string=text)
    assert tokens[0] == "define" and tokens[1] == ["domain", DOMAIN], tokens[:2]
    predicates = next(group[1:] for group in tokens[2:] if group[0] == ":predicates")
    return {name: len(arguments) for name, arguments in parse_predicates(predicates).items()}


def judge(text, task, arities):
    _, types, init, goal = parse_problem("task", 0, DOMAIN, predefined_problem=text)
    objects = {name for names in types.values() for name in names}
    if "table" not in objects:
        yield "no table"
    supported = set()
    for name, *arguments in init:
        supported.add(arguments[0])
        yield from misfits(name, arguments, arities, objects)
    if supported != objects - {"table"}:
        yield f"supports of {sorted(supported ^ (objects - {'table'}))} are not stated"
    stated = [literal(expression) for expression in goal]
    for _, name, *arguments in stated:
        yield from misfits(name, arguments, arities, objects)
    expected = [expected_literal(predicate) for predicate in task["goal"]]
    if stated != expected:
        yield f"the goal is {stated}, not {expected}"


def literal(expression):
    if expression[0] == "not":
        return [False, *expression[1]]
    return [True, *expression]


def expected_literal(predicate):
    name = predicate["predicate"]
    objects = [predicate[key] for key in ("object", "target", "second_target") if key in predicate]
    if name == "on" and len(objects) == 1:
        objects.append("table")
    return [name not in NEGATED, NEGATED.get(name, RENAMED.get(name, name)), *objects]


def misfits(name, arguments, arities, objects):
    if arities.get(name) != len(arguments):
        yield f"{name} with {len(arguments)} objects is not declared"
    unknown = set(arguments) - objects
    if unknown:
        yield f"{sorted(unknown)} are no objects"


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))

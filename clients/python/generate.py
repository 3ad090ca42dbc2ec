"""Writes what is generated in the package: the models of `openapi.yaml`, and the blocking client.

    python generate.py [--out FOLDER]

The blocking client `_sync` is the asynchronous one, `_async`, without its `await`s; only `io.py` is written twice.
Requirements are in requirements.txt. FOLDER stands for `src/tabletopgen`.
"""

import argparse
import re
import subprocess
import sys
import tempfile
import textwrap
from pathlib import Path

import yaml

HERE = Path(__file__).resolve().parent
PACKAGE = HERE / "src" / "tabletopgen"
CONTRACT = HERE.parent.parent / "openapi.yaml"
# The rules of ruff.
RULES = HERE.parent.parent / "python"

# The server checks requests; here bounds would only turn lists of numbers into classes. Unknown fields of answers are
# kept, and those of requests are sent, so that the server refuses them.
BOUNDS = {
    "minimum",
    "maximum",
    "minLength",
    "maxLength",
    "minItems",
    "maxItems",
    "uniqueItems",
    "minProperties",
    "maxProperties",
    "multipleOf",
    "pattern",
    "propertyNames",
    "examples",
}
OPTIONS = [
    "--input-file-type",
    "openapi",
    "--output-model-type",
    "pydantic_v2.BaseModel",
    "--target-python-version",
    "3.10",
    "--base-class",
    "tabletopgen._model.Model",
    "--enum-field-as-literal",
    "all",
    "--collapse-root-models",
    "--openapi-scopes",
    "schemas",
    "--use-standard-collections",
    "--use-union-operator",
    "--use-schema-description",
    "--use-field-description",
    "--use-exact-imports",
    "--disable-timestamp",
    "--formatters",
    "builtin",
]
MODELS_HEADER = '"""The schemas of `openapi.yaml` as classes. Written by generate.py."""'
SYNC_HEADER = "# Written by generate.py from `_async`."

# Files of `_async` and `_sync` that differ otherwise.
BY_HAND = ("__init__.py", "io.py")
WORDS = {
    "_async": "_sync",
    "__aenter__": "__enter__",
    "__aexit__": "__exit__",
    "__aiter__": "__iter__",
    "aclose": "close",
    "aclosing": "closing",
    "aiter_bytes": "iter_bytes",
    "aread": "read",
    "asynchronous": "blocking",
}


class Loader(yaml.SafeLoader):
    """Values of YAML 1.2, in which `on` is a word and no truth value."""


TRUTH = "tag:yaml.org,2002:bool"
Loader.yaml_implicit_resolvers = {
    first: [(tag, form) for tag, form in forms if tag != TRUTH] for first, forms in yaml.SafeLoader.yaml_implicit_resolvers.items()
}
Loader.add_implicit_resolver(TRUTH, re.compile("^(true|false)$"), list("tf"))


def without_bounds(node):
    """The schema with types and names alone."""
    if isinstance(node, list):
        return [without_bounds(part) for part in node]
    if not isinstance(node, dict):
        return node
    kept = {name: part for name, part in node.items() if name not in BOUNDS or isinstance(part, dict)}
    if kept.get("additionalProperties") is False:
        del kept["additionalProperties"]
    if kept.get("type") == "integer" and isinstance(kept.get("default"), float):
        kept["default"] = int(kept["default"])
    return {name: without_bounds(part) for name, part in kept.items()}


def models() -> str:
    document = yaml.load(CONTRACT.read_text(encoding="utf-8"), Loader)
    document["components"]["schemas"] = without_bounds(document["components"]["schemas"])
    with tempfile.TemporaryDirectory() as folder:
        contract, written = Path(folder) / "openapi.yaml", Path(folder) / "models.py"
        contract.write_text(yaml.safe_dump(document, sort_keys=False), encoding="utf-8")
        command = [Path(sys.executable).with_name("datamodel-codegen"), "--input", contract, "--output", written]
        subprocess.run([*command, *OPTIONS, "--custom-file-header", MODELS_HEADER], check=True)
        return written.read_text(encoding="utf-8")


def wrapped(source: str) -> str:
    """The source with lines of at most 120 columns in its descriptions."""
    lines, is_description = [], False
    for line in source.splitlines():
        is_description ^= line.strip() == '"""'
        indent = " " * (len(line) - len(line.lstrip()))
        lines += textwrap.wrap(line, 120, subsequent_indent=indent) if is_description and line else [line]
    return "\n".join([*lines, ""])


def blocking(source: str) -> str:
    """The module of the blocking client that belongs to one of the asynchronous client."""
    source = re.sub(r"\basync (def|with|for)\b", r"\1", source)
    source = re.sub(r"\bawait ", "", source)
    source = re.sub(r"\bAsync([A-Z])", r"\1", source)
    words = re.compile(rf"\b({'|'.join(map(re.escape, WORDS))})\b")
    return f"{SYNC_HEADER}\n{words.sub(lambda found: WORDS[found[0]], source)}"


def write(folder: Path):
    """Every generated file, below `folder`."""
    (folder / "_sync").mkdir(parents=True, exist_ok=True)
    written = [folder / "models.py"]
    written[0].write_text(models(), encoding="utf-8")
    for path in sorted((PACKAGE / "_async").glob("*.py")):
        if path.name not in BY_HAND:
            written.append(folder / "_sync" / path.name)
            written[-1].write_text(blocking(path.read_text(encoding="utf-8")), encoding="utf-8")
    ruff = Path(sys.executable).with_name("ruff")
    subprocess.run([ruff, "check", "--quiet", "--fix", "--select", "I", *written], cwd=RULES, check=True)
    subprocess.run([ruff, "format", "--quiet", *written], cwd=RULES, check=True)
    written[0].write_text(wrapped(written[0].read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=PACKAGE)
    write(parser.parse_args().out)

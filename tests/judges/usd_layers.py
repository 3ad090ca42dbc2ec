"""Is a layer the same whether it was written as text or in the crate format? OpenUSD reads both.

    target/judges/bin/python tests/judges/usd_layers.py FOLDER

FOLDER holds pairs `<name>.usda` and `<name>.usdc`. Everything that a layer can say is compared: which prims and
properties there are and in which order, every field of each, its type and its value. Text against another pair's
crate file must differ. Exits with 1 at the first pair that is not as it should be.
"""

import sys
from pathlib import Path

from pxr import Sdf, Usd

from overheard import Overheard

LIST_OPERATIONS = ("explicitItems", "prependedItems", "appendedItems", "addedItems", "deletedItems", "orderedItems")


def opened(path: Path):
    """The layer, if OpenUSD reads it without a word and builds a stage of it."""
    with Overheard() as heard:
        layer = Sdf.Layer.FindOrOpen(str(path))
        stage = layer and Usd.Stage.Open(layer, load=Usd.Stage.LoadNone)
    # A layer made by chance references files that are not there, which is all that may be said.
    spoken = [line for line in heard.text.splitlines() if line and not about_absent_file(line)]
    if not stage or spoken:
        raise SystemExit(f"{path}: OpenUSD says {spoken or 'nothing, but gives no stage'}")
    return layer


def about_absent_file(line: str) -> bool:
    return "Could not open asset" in line or "_ReportErrors" in line


def difference(a, b):
    """Where two layers differ first, or None."""
    if set(specs(a)) != set(specs(b)):
        return f"only one has {sorted(set(specs(a)) ^ set(specs(b)))}"
    for path in specs(a):
        one, other = a.GetObjectAtPath(path), b.GetObjectAtPath(path)
        if type(one) is not type(other):
            return f"{path}: {one} and {other}"
        if sorted(one.ListInfoKeys()) != sorted(other.ListInfoKeys()):
            return f"{path}: fields {sorted(one.ListInfoKeys())} and {sorted(other.ListInfoKeys())}"
        for key in one.ListInfoKeys():
            if typed(one.GetInfo(key)) != typed(other.GetInfo(key)):
                return f"{path} {key}: {one.GetInfo(key)} and {other.GetInfo(key)}"
        for children in ("nameChildren", "properties"):
            if names(one, children) != names(other, children):
                return f"{path}: {children} in another order"
    # Tells types inside dictionaries, which Python does not.
    return None if a.ExportToString() == b.ExportToString() else "their texts by OpenUSD itself"


def specs(layer) -> list:
    """Paths of everything but targets, which belong to the values of their properties."""
    found = []
    layer.Traverse(Sdf.Path.absoluteRootPath, found.append)
    return [path for path in found if not path.IsTargetPath()]


def names(spec, children: str) -> list:
    return list(getattr(spec, children).keys()) if hasattr(spec, children) else []


def typed(value):
    """A value with its type all the way down, so that 1 is not 1.0 and a token array no string array."""
    if isinstance(value, dict):
        return {key: typed(inner) for key, inner in value.items()}
    if hasattr(value, "isExplicit"):
        return value.isExplicit, [[repr(item) for item in getattr(value, items)] for items in LIST_OPERATIONS]
    if type(value).__module__.startswith("pxr.Vt"):
        return type(value), list(value)
    return type(value), value


def main() -> int:
    texts = sorted(Path(sys.argv[1]).glob("*.usda"))
    if not texts:
        raise SystemExit(f"no layers in {sys.argv[1]}")
    layers = [(opened(text), opened(text.with_suffix(".usdc"))) for text in texts]
    fields = 0
    for text, (as_text, as_crate), (_, another) in zip(texts, layers, layers[1:] + layers[:1]):
        if found := difference(as_text, as_crate):
            raise SystemExit(f"{text} and .usdc differ: {found}")
        if len(layers) > 1 and not difference(as_text, another):
            raise SystemExit(f"{text} is reported as equal to another layer")
        fields += sum(len(as_text.GetObjectAtPath(path).ListInfoKeys()) for path in specs(as_text))
    print(f"OpenUSD reads {len(texts)} layers alike from text and crate, {fields} fields")
    return 0


if __name__ == "__main__":
    sys.exit(main())

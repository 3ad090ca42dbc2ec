"""What the generator of edits and the search for room need of the catalog: words, sizes and uses of categories."""

import tomllib
from dataclasses import dataclass

from tabletopgen_checks.repository import CATALOG


@dataclass
class Category:
    name: str
    label: str
    plural: str
    low_m: tuple
    high_m: tuple
    affordances: tuple
    substance: str


def read() -> dict:
    found = {}
    for path in sorted(CATALOG.glob("*.toml")):
        for entry in tomllib.loads(path.read_text(encoding="utf-8")).get("category", []):
            if "size" in entry:
                label, size = entry["label"], entry["size"]
                found[entry["name"]] = Category(
                    entry["name"], label, entry.get("plural", label + "s"), tuple(size["low_m"]),
                    tuple(size["high_m"]), tuple(entry.get("affordances", ())), entry.get("substance", ""),
                )
    return found


CATEGORIES = read()

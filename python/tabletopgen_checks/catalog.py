"""The categories of config/catalog: words, sizes and uses."""

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


def entries() -> list:
    """Every category as its table in TOML."""
    files = (tomllib.loads(path.read_text(encoding="utf-8")) for path in sorted(CATALOG.glob("*.toml")))
    return [entry for file in files for entry in file.get("category", [])]


def nouns() -> dict[str, tuple[str, str]]:
    """Category to (singular, plural)."""
    return {entry["name"]: (entry["label"], entry.get("plural", entry["label"] + "s")) for entry in entries()}


def read() -> dict:
    words, found = nouns(), {}
    for entry in entries():
        if "size" in entry:
            name, size = entry["name"], entry["size"]
            label, plural = words[name]
            found[name] = Category(
                name, label, plural, tuple(size["low_m"]), tuple(size["high_m"]), tuple(entry.get("affordances", ())),
                entry.get("substance", ""),
            )
    return found


CATEGORIES = read()

"""Who may import whom in this package."""

import ast
import unittest
from pathlib import Path

from tabletopgen_checks.repository import PYTHON

# Each subpackage or module of the package imports those of lines before its own.
LAYERS = [
    {"cargo_results", "problem", "repository"},
    {"catalog", "processes", "result_pages", "virtual_environment"},
    {"client", "dist", "lint", "page", "scene", "service", "step_report", "tools", "webhook_receiver"},
    {"data", "golden", "judges", "language", "robots"},
    {"edits"},
    {"bars"},
    {"demo", "documents", "fuzz"},
    {"test"},
    {"tests"},
]


def imported(path: Path) -> set:
    """The subpackages and modules of this package that a file imports."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module == "tabletopgen_checks":
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and (node.module or "").startswith("tabletopgen_checks."):
            found.add(str(node.module).split(".")[1])
    return found


class Layers(unittest.TestCase):
    def test_imports_point_to_lower_layers(self):
        level = {name: k for k, names in enumerate(LAYERS) for name in names}
        package = PYTHON / "tabletopgen_checks"
        for path in package.rglob("*.py"):
            own = path.relative_to(package).parts[0].removesuffix(".py")
            for name in imported(path) - {own} if own != "__init__" else ():
                with self.subTest(file=str(path.relative_to(package)), imports=name):
                    self.assertLess(level[name], level[own])


if __name__ == "__main__":
    unittest.main()

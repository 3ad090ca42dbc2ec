"""Virtual environments of the target directory, each with pinned packages of PyPI."""

import shutil
import subprocess
import sys
from pathlib import Path

from tabletopgen_checks.problem import Problem


def pins_in(requirements: Path) -> list:
    """The lines of a file of requirements that are no comments."""
    lines = (line.strip() for line in requirements.read_text(encoding="utf-8").splitlines())
    return [line for line in lines if line and not line.startswith("#")]


def environment_of(target: Path, name: str, packages: "list | Path") -> Path:
    """The folder of the environment `name`, made anew where its packages or its Python are others. `packages` are pins,
    or a file of requirements.
    """
    pins = pins_in(packages) if isinstance(packages, Path) else packages
    folder = Path(target) / name
    stamp, wanted = folder / "pins", "\n".join([*pins, sys.version, str(folder)])
    if stamp.is_file() and stamp.read_text(encoding="utf-8") == wanted:
        return folder
    shutil.rmtree(folder, ignore_errors=True)
    subprocess.run([sys.executable, "-m", "venv", folder], check=True)
    pip = [folder / "bin/python", "-m", "pip", "install", "--quiet", "--disable-pip-version-check", *pins]
    if subprocess.run([str(part) for part in pip]).returncode != 0:
        raise Problem(f"PyPI could not deliver {', '.join(pins)}; see above")
    stamp.write_text(wanted, encoding="utf-8")
    return folder

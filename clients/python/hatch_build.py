"""Puts the program into the wheel as the script `tabletopgen`, and names the platform that it runs on.

TABLETOPGEN_PROGRAM is the path of the program; without it the wheel has none, fits every platform, and wants a server.
"""

from __future__ import annotations

import os
import platform
import re
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

VARIABLE = "TABLETOPGEN_PROGRAM"
REPOSITORY = Path(__file__).resolve().parent.parent.parent
# Names of versions of symbols, as the program's table of them has them.
GLIBC = re.compile(rb"GLIBC_2\.(\d+)(?:\.\d+)?\0")


class ProgramHook(BuildHookInterface[Any]):
    """The hook of hatchling that a wheel is built with."""

    PLUGIN_NAME = "custom"

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        named = os.environ.get(VARIABLE)
        if version == "editable" or not named:
            return
        program = Path(named)
        build_data["shared_scripts"][str(program)] = "tabletopgen"
        build_data["pure_python"] = False
        for name in ("LICENSE", "NOTICE"):
            build_data["force_include"][str(REPOSITORY / name)] = f"tabletopgen/{name}"
        build_data["tag"] = f"py3-none-{platform_of(program)}"


def platform_of(program: Path) -> str:
    """The tag of the platform: for Linux the oldest glibc that has all symbols of the program."""
    machine = platform.machine()
    if platform.system() != "Linux":
        raise RuntimeError(f"wheels with the program are made on Linux; unset {VARIABLE} for one without it")
    minors = [int(minor) for minor in GLIBC.findall(program.read_bytes())]
    if not minors:
        raise RuntimeError(f"{program} names no version of glibc; is it the program for Linux with glibc?")
    return f"manylinux_2_{max(minors)}_{machine}"

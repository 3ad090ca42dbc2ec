"""The wheel in a clean environment, installed as the README says, with the first example and the program in it."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import time
import zipfile
from pathlib import Path

import pytest

from test_readme import fences

CLIENT = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="module")
def wheel(program: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel") / "target" / "wheel"
    packed = program
    if strip := shutil.which("strip"):
        # A development build is large.
        packed = folder.parent / "tabletopgen"
        packed.parent.mkdir()
        subprocess.run([strip, "-o", packed, program], check=True)
    command = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)]
    subprocess.run(command, cwd=CLIENT, env=os.environ | {"TABLETOPGEN_PROGRAM": str(packed)}, check=True)
    (made,) = folder.glob("*.whl")
    return made


def test_its_name_states_the_oldest_glibc_that_the_program_runs_on(wheel: Path, program: Path) -> None:
    tag = re.fullmatch(r"tabletopgen-[\d.]+-py3-none-manylinux_2_(\d+)_\w+\.whl", wheel.name)
    assert tag and 17 <= int(tag[1]) <= 60
    listed = subprocess.run(["objdump", "-T", program], capture_output=True, text=True, check=True).stdout
    assert int(tag[1]) == max(int(minor) for minor in re.findall(r"GLIBC_2\.(\d+)", listed))
    names = zipfile.ZipFile(wheel).namelist()
    assert any(name.endswith(".data/scripts/tabletopgen") for name in names)
    assert {"tabletopgen/py.typed", "tabletopgen/models.py", "tabletopgen/_sync/client.py", "tabletopgen/NOTICE"} <= set(names)


def test_five_lines_of_the_readme_give_a_scene_in_mujoco_in_a_clean_environment(wheel: Path, tmp_path: Path) -> None:
    began = time.monotonic()
    subprocess.run([sys.executable, "-m", "venv", tmp_path / "venv"], check=True)
    commands = next(text for language, text in fences() if language == "sh").splitlines()
    assert commands.pop(0) == "make wheel", "the fixture has made it"
    environment = {"PATH": f"{tmp_path / 'venv/bin'}:/usr/bin:/bin", "HOME": os.environ["HOME"], "PIP_QUIET": "1"}
    environment |= {name: value for name, value in os.environ.items() if name.startswith(("PIP_", "http", "HTTP", "SSL"))}
    subprocess.run(["bash", "-ec", "\n".join(commands)], cwd=wheel.parents[2], env=environment, check=True)
    installed_secs = time.monotonic() - began
    script, expected = (next(text for language, text in fences() if language == kind) for kind in ("python", "output"))
    # Nothing of this repository but what was installed.
    run = subprocess.run([tmp_path / "venv/bin/python", "-c", script], cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert (run.returncode, run.stdout) == (0, expected), run.stderr
    secs = time.monotonic() - began - installed_secs
    print(f"\n{wheel.name}: {wheel.stat().st_size / 1e6:.1f} MB, installed in {installed_secs:.1f} s, a scene in {secs:.1f} s")
    version = subprocess.check_output(["tabletopgen", "--version"], env=environment, text=True)
    assert re.search(r"\d+\.\d+\.\d+", version)

"""The notebooks run from the first cell to the last, with parameters that leave little to do."""

from __future__ import annotations

import importlib
import re
from pathlib import Path
from typing import Any

import pytest
from nbclient import NotebookClient

nbformat: Any = importlib.import_module("nbformat")
HERE = Path(__file__).resolve().parent
NOTEBOOKS = sorted((HERE.parent / "notebooks").glob("*.ipynb"))
IMAGE = HERE.parents[2] / "docs" / "demo_table.png"


def executed(name: str, folder: Path, parameters: str) -> str:
    """Texts of all outputs, after a notebook was run with other parameters."""
    notebook: Any = nbformat.read(HERE.parent / "notebooks" / name, as_version=4)
    (place,) = [number for number, cell in enumerate(notebook.cells) if "parameters" in cell.metadata.get("tags", ())]
    notebook.cells.insert(place + 1, nbformat.v4.new_code_cell(parameters))
    NotebookClient(notebook, timeout=400, kernel_name="python3", resources={"metadata": {"path": str(folder)}}).execute()
    texts = []
    for output in (output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs):
        # Bars of progress are there, too.
        assert "Warning" not in output.get("text", ""), output
        texts.append(output.get("text") or "\n".join(map(str, output["data"].values())))
    return "\n".join(texts)


def test_a_text_comes_to_rest_in_mujoco(program: Path, tmp_path: Path) -> None:
    shown = executed("text_to_mujoco.ipynb", tmp_path, 'SENTENCE = "A desk with a mug and an apple"\nSIMULATED_SECS = 1.0')
    distances_mm = [float(number) for number in re.findall(r": ([\d.]+) mm in 1 s", shown)]
    assert len(distances_mm) == 2 and max(distances_mm) < 5
    pushed = re.search(r"went (\d+) mm", shown)
    assert pushed and int(pushed[1]) > 20
    assert "data:image/jpeg;base64," in shown and (tmp_path / "scene.rrd").is_file()


def test_episodes_become_a_policy_that_predicts_better_than_standing_still(program: Path, tmp_path: Path) -> None:
    few = 'EPISODES, HELD_OUT, CAMERAS, SIZE_PX = 3, 1, ["front"], 64'
    shown = executed("episodes_to_policy.ipynb", tmp_path, few)
    errors = re.search(r"error ([\d.]+) rad; of a policy that stays where it is ([\d.]+) rad", shown)
    assert errors and float(errors[1]) < float(errors[2]), shown
    assert "3 episodes" in shown and (tmp_path / "episode.rrd").is_file()


def test_an_image_becomes_a_scene_that_is_edited(program: Path, tmp_path: Path) -> None:
    shown = executed("image_to_scene.ipynb", tmp_path, f"IMAGE = {str(IMAGE)!r}")
    counts = re.search(r"(\d+) objects, (\d+) after the edit", shown)
    assert counts and int(counts[1]) > int(counts[2]) > 0


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_outputs_are_not_committed(path: Path) -> None:
    notebook: Any = nbformat.read(path, as_version=4)
    nbformat.validate(notebook)
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert cells and not any(cell.outputs or cell.execution_count for cell in cells)


def test_every_notebook_is_run() -> None:
    source = Path(__file__).read_text(encoding="utf-8")
    assert [path.name for path in NOTEBOOKS] == sorted(set(re.findall(r'executed\("(\w+\.ipynb)"', source)))

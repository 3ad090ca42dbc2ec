"""Files for Rerun, opened by its own reader."""

from __future__ import annotations

import importlib
import json
import math
from pathlib import Path
from typing import Any

import pytest

from conftest import SMALL_RECORDING
from tabletopgen import Recording, Scene, rrd

chunks: Any = importlib.import_module("rerun.chunk")


def read(path: Path) -> dict[str, dict[str, list[Any]]]:
    """Values of the columns of each entity, over all chunks."""
    found: dict[str, dict[str, list[Any]]] = {}
    for chunk in chunks.RrdReader(path).stream().to_chunks():
        columns = found.setdefault(chunk.entity_path, {})
        for name, values in chunk.to_record_batch().to_pydict().items():
            columns.setdefault(name, []).extend(values)
    return found


def test_a_scene_has_its_bodies_where_they_are_and_its_camera(made: Scene, tmp_path: Path) -> None:
    path = made.to_rerun(tmp_path / "new" / "scene.rrd")
    entities = read(path)
    instances = {one["name"]: one for one in made.file("scene.json")["instances"]}
    assert {"/world/table/mesh", "/world/camera", *(f"/world/{name}/mesh" for name in instances)} <= set(entities)
    for name, instance in instances.items():
        ((place,),) = entities[f"/world/{name}"]["Transform3D:translation"]
        assert place == pytest.approx(instance["translation_m"], abs=1e-6)
        assert entities[f"/world/{name}"]["mass_kg"] == [[instance["mass_kg"]]]
        ((blob,),) = entities[f"/world/{name}/mesh"]["Asset3D:blob"]
        assert bytes(blob) == made.file_bytes(f"glb/{name}.glb")
    ((turned,),) = entities["/world/mug_1/mesh"]["Transform3D:rotation_axis_angle"]
    assert turned["angle"] == pytest.approx(math.pi / 2)
    ((image,),) = entities["/world/camera"]["EncodedImage:blob"]
    assert bytes(image).startswith(b"\x89PNG")


def test_an_episode_has_its_frames_and_videos(recorded: Recording, tmp_path: Path) -> None:
    path = recorded.to_rerun(tmp_path / "episode.rrd")
    entities = read(path)
    info = json.loads((recorded.to_lerobot(tmp_path / "dataset") / "meta" / "info.json").read_text())
    frames, width = info["total_frames"], info["features"]["action"]["shape"][0]
    (actions,) = [entity for entity in entities if entity.endswith("/action")]
    assert [len(frame) for frame in entities[actions]["Scalars:scalars"]] == [width] * frames
    (video,) = [entity for entity, columns in entities.items() if "VideoStream:sample" in columns]
    assert SMALL_RECORDING["cameras"][0] in video and len(entities[video]["VideoStream:sample"]) == frames
    with pytest.raises(ValueError, match="no episode 7"):
        recorded.to_rerun(tmp_path / "none.rrd", episode=7)


def test_a_folder_that_is_no_dataset_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        rrd.write_episode(tmp_path / "nowhere", 0, tmp_path / "x.rrd")

"""A scene in simulators, where their packages are installed."""

from __future__ import annotations

import importlib
from typing import Any

import pytest

from tabletopgen import Scene, errors, simulators


def test_it_falls_nowhere_in_pybullet(made: Scene) -> None:
    p: Any = pytest.importorskip("pybullet", reason="there are no packages of PyBullet for this Python")
    physics = p.connect(p.DIRECT)
    p.setGravity(0, 0, -9.81, physicsClientId=physics)
    bodies = made.pybullet(physics)
    assert set(bodies) == {"table", "mug_1", "apple_1"}
    before = p.getBasePositionAndOrientation(bodies["apple_1"], physicsClientId=physics)[0]
    for _ in range(24):
        p.stepSimulation(physicsClientId=physics)
    after = p.getBasePositionAndOrientation(bodies["apple_1"], physicsClientId=physics)[0]
    assert abs(after[2] - before[2]) < 0.005
    p.disconnect(physics)


def test_it_falls_nowhere_in_sapien(made: Scene) -> None:
    sapien: Any = importlib.import_module("sapien")
    scene = made.sapien()
    apple = next(entity for entity in scene.entities if entity.name == "apple_1")
    before = apple.pose.p.copy()
    for _ in range(20):
        scene.step()
    assert abs(apple.pose.p - before).max() < 0.005
    own = sapien.Scene([sapien.physx.PhysxCpuSystem()])
    assert made.sapien(own) is own and {entity.name for entity in own.entities} >= {"table", "mug_1", "apple_1"}


def test_its_stage_has_bodies_in_usd(made: Scene) -> None:
    usd: Any = importlib.import_module("pxr.Usd")
    physics: Any = importlib.import_module("pxr.UsdPhysics")
    stage = usd.Stage.Open(str(made.usd_path))
    assert sum(prim.HasAPI(physics.RigidBodyAPI) for prim in stage.Traverse()) == 3


def test_a_missing_package_is_an_error_that_names_it(made: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> Any:
        raise ImportError(name)

    monkeypatch.setattr(importlib, "import_module", missing)
    with pytest.raises(errors.MissingPackageError, match="pip install mujoco"):
        simulators.mujoco(made.usd_path)

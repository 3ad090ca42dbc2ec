"""Sensitivity of a policy: the factor that decides is named, chance is not, and what varies together is said."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tabletopgen.env import EnvironmentFolder, SceneEnv
from tabletopgen.env.__main__ import main
from tabletopgen.env.rollout_factors import StartFactors
from tabletopgen.env.rollout_folder import RolloutFolder
from tabletopgen.env.sensitivity import sensitivity
from tabletopgen.env.sensitivity_report import NAMED_BELOW
from tabletopgen.env.sensitivity_splits import ranked
from tabletopgen.env.sensitivity_table import color_name, table_of, values_of

pytest.importorskip("sklearn", reason="scikit-learn is not installed")
pytest.importorskip("matplotlib", reason="matplotlib is not installed")

Rule = Callable[[dict[str, Any], np.random.Generator], bool]
COLORS = {"red": [0.8, 0.1, 0.1], "green": [0.1, 0.7, 0.2], "blue": [0.1, 0.2, 0.8], "white": [0.9, 0.9, 0.9]}


def record_of(number: int, random: np.random.Generator, fails: Rule) -> dict[str, Any]:
    """The record of an episode with factors that are drawn independently."""
    color = str(random.choice(list(COLORS)))
    own = {
        "category": "can",
        "world_from_object": {"translation_m": random.uniform(-0.2, 0.2, 3).tolist(), "rotation_xyzw": [0.0, 0.0, 0.0, 1.0]},
        "mass_kg": float(random.uniform(0.2, 0.6)),
        "friction": float(random.uniform(0.4, 0.6)),
        "tint": random.uniform(0.85, 1.15, 3).tolist(),
        "color": COLORS[color],
        "size_m": [0.06, 0.06, 0.12],
    }
    factors = {name: float(random.uniform()) for name in ("light_brightness", "light_turn_rad", "camera_front_offset_m", "distance_m")}
    factors |= {"mass_kg": own["mass_kg"], "objects_present": float(random.integers(2, 5))}
    record = {
        "episode": number,
        "environment": "environment",
        "start": number,
        "seed": number,
        "moved": [{"object": "can_1"}],
        "objects": {"can_1": own},
        "light": {"direction": [0.2, 0.35, -1.0]},
        "table_tint": random.uniform(0.8, 1.2, 3).tolist(),
        "wording": str(random.choice(["put the can away", "store the can"])),
        "task": "on(can, plate)",
        "factors": factors,
    }
    return {**record, "success": not fails({**factors, "color": color, **record}, random)}


def written(folder: Path, count: int, fails: Rule, *, seed: int = 0, policy: str = "planted") -> Path:
    """The folder of a rollout with such episodes."""
    random = np.random.default_rng(seed)
    out = RolloutFolder(folder)
    document = {"policy": policy, "policy_digest": None, "environments": ["environment"], "digests": ["0"]}
    with out.held(document):
        for number in range(count):
            out.append(record_of(number, random, fails))
    return folder


def wrong(random: np.random.Generator, is_failure: bool) -> bool:
    """An outcome that is another one in a tenth of all episodes."""
    return is_failure != (random.uniform() < 0.1)


@pytest.mark.parametrize(
    ("fails", "name", "threshold"),
    [
        (lambda one, random: wrong(random, one["light_brightness"] < 0.3), "light_brightness", 0.3),
        (lambda one, random: wrong(random, one["mass_kg"] > 0.45), "mass_kg", 0.45),
        (lambda one, random: wrong(random, one["color"] == "red"), "moved_color", "red"),
        (lambda one, random: wrong(random, one["wording"] == "store the can"), "wording", None),
    ],
)
def test_a_planted_factor_is_named_first(fails: Rule, name: str, threshold: float | str | None, tmp_path: Path) -> None:
    found = sensitivity([written(tmp_path / "rollout", 120, fails)], tmp_path / "out")
    assert found["named"][0] == name == found["factors"][0]["name"]
    best = found["factors"][0]
    assert best["corrected"] <= 0.01 and best["explained"] > 0.2
    rates = [best["split"][side]["rate"] for side in ("first", "second")]
    assert max(rates) > 0.75 and min(rates) < 0.25
    if isinstance(threshold, float):
        low, high = best["split"]["about_as_good"]
        assert low <= threshold <= high and best["split"]["threshold"] == pytest.approx(threshold, abs=0.08)
    elif threshold is not None:
        assert best["split"]["word"] == threshold
    model = next(one for one in found["model"]["models"] if one["kind"] == found["model"]["best"])
    assert model["log_loss"] < found["model"]["base_log_loss"] - 0.1 and model["auc"] > 0.75
    assert model["importances"][0]["name"] == name and model["importances"][0]["low"] > 0
    text = (tmp_path / "out" / "sensitivity.md").read_text(encoding="utf-8")
    assert f"1. **{name}**" in text and f"](plots/{name}.svg)" in text
    assert (tmp_path / "out" / "plots" / f"{name}.svg").read_text().startswith("<?xml")


def test_chance_names_nothing(tmp_path: Path) -> None:
    random, named = np.random.default_rng(1), []
    for _ in range(30):
        records = [record_of(number, random, lambda _, own: bool(own.uniform() < 0.3)) for number in range(80)]
        named.append(ranked(table_of(records, ["environment"] * 80))[0].corrected < NAMED_BELOW)
    # One in twenty is expected; more than five of thirty come in one case of 150.
    assert sum(named) <= 5
    found = sensitivity([written(tmp_path / "rollout", 100, lambda _, own: bool(own.uniform() < 0.3))], tmp_path / "out")
    assert found["named"] == []
    text = (tmp_path / "out" / "sensitivity.md").read_text(encoding="utf-8")
    assert "No recorded factor explains the failures" in text and "No model predicts failures" in text


def test_factors_that_vary_together_are_called_indistinguishable(tmp_path: Path) -> None:
    random = np.random.default_rng(4)

    def fails(one: dict[str, Any], own: np.random.Generator) -> bool:
        one["factors"]["light_turn_rad"] = 3 * one["light_brightness"] + 0.001 * random.uniform()
        return wrong(own, one["light_brightness"] < 0.4)

    found = sensitivity([written(tmp_path / "rollout", 150, fails)], tmp_path / "out")
    first, second = found["factors"][:2]
    assert {first["name"], second["name"]} == {"light_brightness", "light_turn_rad"}
    assert first["relation"] == "separate" and (second["relation"], second["to"]) == ("indistinguishable", first["name"])
    assert f"cannot tell it from {first['name']}" in (tmp_path / "out" / "sensitivity.md").read_text(encoding="utf-8")


def test_two_causes_are_separate_and_what_follows_one_is_not(tmp_path: Path) -> None:
    random = np.random.default_rng(5)

    def fails(one: dict[str, Any], _: np.random.Generator) -> bool:
        one["factors"]["distance_m"] = one["light_brightness"] + 0.25 * random.normal()
        return bool(one["light_brightness"] < 0.3 or one["mass_kg"] > 0.5)

    found = sensitivity([written(tmp_path / "rollout", 300, fails)], tmp_path / "out")
    relations = {row["name"]: (row["relation"], row["to"]) for row in found["factors"] if row["name"] in found["named"]}
    assert relations["light_brightness"] == relations["mass_kg"] == ("separate", None)
    assert relations["distance_m"] == ("follows", "light_brightness")


def test_episodes_of_one_start_are_no_independent_evidence(tmp_path: Path) -> None:
    """Eight starts, twenty times each: as many episodes say nothing about the factors of eight starts."""
    out = RolloutFolder(tmp_path / "rollout")
    starts = [{**record_of(number, np.random.default_rng(number), lambda *_: False), "success": number % 2 == 0} for number in range(8)]
    with out.held({"policy": "planted", "policy_digest": None, "environments": ["environment"], "digests": ["0"]}):
        for number in range(160):
            out.append({**starts[number % 8], "episode": number})
    found = sensitivity([out.folder], tmp_path / "out")
    assert found["starts"] == 8 and found["named"] == [] and found["model"] is None


@pytest.mark.parametrize(("fails", "said"), [(False, "No episode failed"), (True, "Every episode failed")])
def test_without_failures_or_successes_nothing_is_explained(fails: bool, said: str, tmp_path: Path) -> None:
    found = sensitivity([written(tmp_path / "rollout", 20, lambda *_: fails)], tmp_path / "out")
    assert found["named"] == [] and found["factors"] == []
    assert said in (tmp_path / "out" / "sensitivity.md").read_text(encoding="utf-8")


def test_equal_rollouts_give_equal_files(tmp_path: Path) -> None:
    folder = written(tmp_path / "rollout", 60, lambda one, _: one["light_brightness"] < 0.3)
    contents = []
    for name in ("one", "two"):
        assert main(["sensitivity", str(folder), "--out", str(tmp_path / name)]) == 0
        contents.append({path.name: path.read_bytes() for path in sorted((tmp_path / name).rglob("*.*"))})
    assert contents[0] == contents[1] and len(contents[0]) == 8


def test_several_rollouts_of_one_policy_are_one_table(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    one = written(tmp_path / "one", 60, lambda one, _: one["light_brightness"] < 0.3)
    two = written(tmp_path / "two", 60, lambda one, _: one["light_brightness"] < 0.3, seed=1)
    other = written(tmp_path / "other", 5, lambda *_: False, policy="another")
    assert main(["sensitivity", str(one), str(two), "--out", str(tmp_path / "out")]) == 0
    # Starts of one environment are the same in both rollouts.
    assert json.loads(capsys.readouterr().out) == {"named": ["light_brightness"], "episodes": 120, "out": str(tmp_path / "out")}
    assert json.loads((tmp_path / "out" / "sensitivity.json").read_text())["starts"] == 60
    for folders, message in (([one, other], "analyze policies one by one"), ([one, one], "named twice"), ([], "no rollout is named")):
        with pytest.raises(ValueError, match=message):
            sensitivity(folders, tmp_path / "out")
    with pytest.raises(ValueError, match="no finished episode"):
        sensitivity([written(tmp_path / "empty", 0, lambda *_: False)], tmp_path / "out")


def test_a_factor_that_some_episodes_lack_is_analyzed_in_the_others() -> None:
    random = np.random.default_rng(0)
    records = [record_of(number, random, lambda _, own: bool(own.uniform() < 0.5)) for number in range(30)]
    for record in records[:5]:
        record["factors"]["distance_m"] = None
    table = table_of(records, ["environment"] * 30)
    column = {one.name: one for one in table.factors}["distance_m"]
    assert column.present.tolist() == [False] * 5 + [True] * 25 and "task" in table.constant
    assert table.merged == {"mass_kg": ("moved_mass_kg",)}


@pytest.mark.parametrize(
    ("color", "name"),
    [
        ((0.8, 0.1, 0.1), "red"),
        ((0.9, 0.5, 0.1), "orange"),
        ((0.9, 0.8, 0.1), "yellow"),
        ((0.1, 0.6, 0.2), "green"),
        ((0.1, 0.6, 0.6), "cyan"),
        ((0.1, 0.2, 0.7), "blue"),
        ((0.5, 0.1, 0.6), "purple"),
        ((0.7, 0.1, 0.2), "red"),
        ((0.05, 0.02, 0.03), "black"),
        ((0.5, 0.5, 0.48), "gray"),
        ((0.9, 0.9, 0.88), "white"),
    ],
)
def test_colors_have_names(color: tuple[float, float, float], name: str) -> None:
    assert color_name(color) == name


def test_factors_of_a_start_are_those_of_the_simulation(environment: EnvironmentFolder, task_scene: Path) -> None:
    instances = json.loads((task_scene / "scene.json").read_text(encoding="utf-8"))["instances"]
    stated = next(one for one in instances if one["name"] == "soda_can_1")
    env = SceneEnv(folder=environment.folder, images=False)
    factors = StartFactors(env, environment)
    for number, start in enumerate(environment.starts):
        env.reset(options={"start": number})
        found, drawn = factors.of(start), start.objects["soda_can_1"]
        own = found["objects"]["soda_can_1"]
        assert own["size_m"] == stated["size_m"] and own["friction"] == pytest.approx(stated["friction"]["dynamic"] * drawn.friction_factor)
        assert own["mass_kg"] == pytest.approx(stated["mass_kg"] * drawn.mass_factor, rel=1e-4)
        assert found["factors"]["light_brightness"] == pytest.approx(0.6 * start.light.brightness_factor)
        # A texture of greens, tinted; MuJoCo makes no texture brighter.
        tinted = [base * min(tint, 1.0) for base, tint in zip([0.42, 0.56, 0.27], drawn.tint, strict=True)]
        assert own["color"] == pytest.approx(tinted, abs=0.01)
        row = values_of(found)
        assert row["moved_color"] in ("green", "yellow") and row["moved_size_m"] == max(stated["size_m"])
    env.close()

"""Does layouts.py tell layouts apart that are right and wrong in known ways? test_judges.py calls this."""

from pathlib import Path

import layouts
from verdict import bodies, read_scene


def check_layouts(good: Path) -> int:
    """Of a good bundle with two movable bodies that stand apart on the table; the number of layouts."""
    movable = [body for body in bodies(read_scene(good)) if body["movable"]]
    a, b = movable[0]["name"], movable[1]["name"]
    shipped = {body["name"]: body["world_from_object"] for body in movable}

    def findings(**changed):
        poses = {name: pose.tolist() for name, pose in (shipped | changed).items() if pose is not None}
        return layouts.judge({"bundle": str(good), "world_from_object": poses})

    def raised(name, height_m):
        pose = shipped[name].copy()
        pose[2, 3] += height_m
        return pose

    names = sorted(shipped)
    found = findings()
    assert found["colliding"] == [] and sorted(found["at_rest"]) == names, found
    assert found["placed"] == len(names) and found["hull_depth_mm"] < 1.0, found
    found = findings(**{a: shipped[b]})
    assert [a, b] in [pair[:2] for pair in found["colliding"]], found
    # Into the table by 5 mm.
    found = findings(**{a: raised(a, -0.005)})
    (pair,) = found["colliding"]
    assert pair[:2] == ["table", a] and 1.0 < pair[2] < 5.5 and found["hull_depth_mm"] > 1.0, found
    # Falls by 20 cm.
    found = findings(**{a: raised(a, 0.2)})
    assert found["colliding"] == [] and a not in found["at_rest"] and found["moved_mm"][a] > 150.0, found
    # Lands where it is 2 mm lower.
    found = findings(**{a: raised(a, 0.002)})
    assert a in found["at_rest"] and 1.5 < found["moved_mm"][a] < 5.0, found
    found = findings(**{a: None})
    assert found["placed"] == len(names) - 1 and sorted(found["at_rest"]) == [name for name in names if name != a], found
    return 6

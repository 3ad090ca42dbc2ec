"""Places the objects of a bundle on its table with NVIDIA's scene-synthesizer. Runs in the environment of that package.

    python place.py [--bundle BUNDLE] --poses upright|stable --seed N

The objects are the collision hulls of the bundle, in the order of scene.json; the support is a solid as high as the
table with the outline of its top. `upright` turns objects about the vertical only; `stable` samples the package's
stable poses, about the center of mass that scene.json states. Everything else is the package's default: uniform
positions, 2 cm from the edge, 2 mm above the table and from each other, 100 tries per object. Prints one JSON object:
CPU seconds of the parts, and `world_from_object` (4x4, meters, z up) of what was placed. Without a bundle it only
imports.
"""

import argparse
import json
import logging
import time
from pathlib import Path

import scene_synthesizer
import shapely
import trimesh
from scene_synthesizer.utils import (
    PositionIteratorUniform,
    orientation_generator_stable_poses,
    orientation_generator_uniform_around_z,
)

TABLE, TOP = "table", "top"


def main():
    # From the start of the process.
    imported_s = time.process_time()
    logging.disable(logging.WARNING)
    parser = argparse.ArgumentParser()
    parser.add_argument("--bundle", type=Path)
    parser.add_argument("--poses", choices=("upright", "stable"), required=True)
    parser.add_argument("--seed", type=int, required=True)
    given = parser.parse_args()
    if given.bundle is None:
        return
    content = json.loads((given.bundle / "scene.json").read_text(encoding="utf-8"))
    assets = {one["name"]: asset_of(given.bundle / "urdf" / one["name"]) for one in content["instances"]}
    table = table_of(content["table"])
    read_s = time.process_time()
    scene = placed(content, assets, table, given.poses, given.seed)
    placed_s = time.process_time()
    names = [name for name in assets if name in scene.get_object_names()]
    found = {name: scene.get_transform(name).tolist() for name in names}
    seconds = {"import": imported_s, "read": read_s - imported_s, "place": placed_s - read_s}
    print(json.dumps({"cpu_s": seconds, "world_from_object": found}))


def asset_of(folder: Path):
    """All hulls as one mesh: with a geometry for each the package takes four times as long."""
    hulls = [trimesh.load_mesh(path) for path in sorted(folder.glob("hull_*.obj"))]
    return scene_synthesizer.assets.TrimeshAsset(trimesh.util.concatenate(hulls))


def table_of(table: dict):
    solid = trimesh.creation.extrude_polygon(shapely.Polygon(table["outline_m"]), table["height_m"])
    solid.apply_translation([0.0, 0.0, -table["height_m"]])
    return scene_synthesizer.assets.TrimeshAsset(solid)


def placed(content, assets, table, poses, seed):
    scene = scene_synthesizer.Scene(seed=seed)
    scene.add_object(table, TABLE)
    scene.label_support(TOP, obj_ids=TABLE)
    if poses == "stable":
        orientations = {
            one["name"]: orientation_generator_stable_poses(
                assets[one["name"]], seed=scene._rng, convexify=True, center_mass=one["center_of_mass_m"]
            )
            for one in content["instances"]
        }
    else:
        orientations = orientation_generator_uniform_around_z(seed=scene._rng)
    scene.place_objects(
        obj_id_iterator=iter(assets),
        obj_asset_iterator=iter(assets.values()),
        obj_support_id_iterator=scene.support_generator(TOP),
        obj_position_iterator=PositionIteratorUniform(seed=scene._rng),
        obj_orientation_iterator=orientations,
    )
    return scene


if __name__ == "__main__":
    main()

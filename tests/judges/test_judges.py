"""Do the judges reject what they should? Breaks a good bundle in known ways.

    target/judges/bin/python tests/judges/test_judges.py GOOD_BUNDLE_DIR

The bundle needs two movable bodies that stand apart on the table.
"""

import importlib
import json
import re
import shutil
import struct
import sys
import tempfile
from pathlib import Path

import numpy as np
import trimesh
from pxr import Sdf

import collisions
import solids
from judge import SLOW
from left_out import LEFT_OUT
from test_layouts import check_layouts


def edit_text(path, change):
    before = path.read_text(encoding="utf-8")
    after = change(before)
    assert before != after, f"the change leaves {path} as it was"
    path.write_text(after, encoding="utf-8")


def edit_json(path, change):
    document = json.loads(path.read_text(encoding="utf-8"))
    change(document)
    path.write_text(json.dumps(document), encoding="utf-8")
    return document


def edit_scene(bundle, change):
    return edit_json(bundle / "scene.json", change)


def edit_glb(path, change):
    data = path.read_bytes()
    (length,) = struct.unpack_from("<I", data, 12)
    document = json.loads(data[20 : 20 + length])
    change(document)
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    rest = data[20 + length :]
    header = struct.pack("<4sIII4s", b"glTF", 2, 20 + len(text) + len(rest), len(text), b"JSON")
    path.write_bytes(header + text + rest)


def hull(folder):
    """The first hull that is a mesh; cups have some."""
    return min(folder.glob("hull_*.obj"))


def first(bundle):
    return json.loads((bundle / "scene.json").read_text(encoding="utf-8"))["instances"][0]["name"]


def one_on_the_other(bundle):
    def change(scene):
        a, b = scene["instances"][:2]
        a["translation_m"], a["rotation_xyzw"] = b["translation_m"], b["rotation_xyzw"]

    edit_scene(bundle, change)


def lifted(bundle):
    """Lifts a body by 20 cm in scene and MJCF alike: consistent, but it falls."""

    def change(scene):
        instance = scene["instances"][0]
        old = instance["translation_m"]
        new = [old[0], old[1], old[2] + 0.2]
        instance["translation_m"] = new
        def number(v):
            return np.format_float_positional(v, trim="-") if v else "0"
        name = instance["name"]
        edit_text(
            bundle / "mjcf/scene.xml",
            lambda text: text.replace(
                f'<body name="{name}" pos="{" ".join(map(number, old))}"',
                f'<body name="{name}" pos="{" ".join(map(number, new))}"',
            ),
        )

    edit_scene(bundle, change)


def hole(document):
    indices = document["meshes"][0]["primitives"][0]["indices"]
    document["accessors"][indices]["count"] -= 3


def index_out_of_range(document):
    position = document["meshes"][0]["primitives"][0]["attributes"]["POSITION"]
    document["accessors"][position]["count"] -= 1


BREAKS = {
    "schema": [
        lambda b: edit_scene(b, lambda s: s.update(surprise=1)),
        lambda b: edit_scene(b, lambda s: s["instances"][0].update(mass_kg=-1)),
        lambda b: edit_scene(b, lambda s: s["instances"][0]["support"].update(parent=s["instances"][0]["name"])),
        lambda b: (b / "README.md").unlink(),
        lambda b: (b / "extra.txt").write_text("?"),
        lambda b: edit_text(b / "mjcf/scene.xml", lambda t: t + " "),
    ],
    "report": [
        lambda b: edit_json(b / "report.json", lambda r: r.update(surprise=1)),
        lambda b: edit_json(b / "report.json", lambda r: r["metrics"].update(ss=0.5)),
        lambda b: edit_json(b / "report.json", lambda r: r.update(verdict="quarantine")),
        lambda b: edit_json(b / "report.json", lambda r: r["bodies"].pop()),
        lambda b: edit_text(b / "report.html", lambda t: t.replace("</h2>", "</h3>", 1)),
        lambda b: edit_text(b / "report.html", lambda t: t.replace('<h2>', '<h2><img src="https://example.invalid/a.png" />', 1)),
        lambda b: edit_text(b / "report.html", lambda t: t.replace("<h2>", '<h2 onclick="alert(1)">', 1)),
        lambda b: edit_text(b / "report.html", lambda t: re.sub('(<p class="why">)[^<]*', r"\1It is fine.", t)),
    ],
    "usd": [
        lambda b: edit_text(b / "usd/scene.usda", lambda t: t.replace('upAxis = "Z"', 'upAxis = "Y"')),
        lambda b: edit_text(b / "usd/scene.usda", lambda t: t.replace("rigidBodyEnabled = 0", "rigidBodyEnabled = 1")),
        lambda b: edit_attributes(b, "physics:approximation", lambda a: setattr(a, "default", "convexDecomposition")),
        lambda b: edit_attributes(b, "physics:mass", lambda a: setattr(a, "default", a.default + 1)),
        lambda b: edit_text(b / "urdf/table/table.urdf", lambda t: re.sub('<box size="', '<box size="1', t)),
        lambda b: edit_attributes(b, "extent", lambda a: setattr(a, "default", [(-9, -9, -9), (9, 9, 9)])),
        lambda b: edit_attributes(b, "physics:dynamicFriction", lambda a: setattr(a, "name", "physics:someFriction")),
        # Only OpenUSD's own validators see this one.
        lambda b: edit_prop(b, without_binding_schema),
        lambda b: cut(prop(b), 0.9),
    ],
    "robotics_prop": [
        lambda b: edit_prop(b, without_provenance),
        lambda b: edit_attributes(b, "points", lambda a: setattr(a, "default", list(a.default)[:-1])),
    ],
    "mjcf": [
        lambda b: edit_text(b / "mjcf/scene.xml", lambda t: t.replace("<freejoint", "<!-- <freejoint", 1).replace("<inertial", " --> <inertial", 2).replace(" --> <inertial", "<inertial", 1)),
        lambda b: edit_text(b / "mjcf/scene.xml", lambda t: t.replace('<inertial pos="', '<inertial pos="1')),
        lambda b: edit_text(b / "mjcf/scene.xml", lambda t: t.replace("</mujoco>", "")),
        lambda b: (b / f"mjcf/{first(b)}/{first(b)}.xml").unlink(),
        lambda b: edit_text(b / f"mjcf/{first(b)}/{first(b)}.xml", lambda t: t.replace("top_site", "upper_site")),
        lambda b: min((b / "mjcf/assets/hulls").glob(f"{first(b)}_*.obj")).unlink(),
    ],
    "urdf": [
        lambda b: hull(b / f"urdf/{first(b)}").unlink(),
        lambda b: edit_text(b / f"urdf/{first(b)}/{first(b)}.urdf", lambda t: t.replace('<mass value="', '<mass value="1')),
        lambda b: edit_text(b / "urdf/scene.urdf", lambda t: t.replace('<origin xyz="', '<origin xyz="1')),
        lambda b: edit_text(b / "urdf/scene.urdf", lambda t: t.replace(f"{first(b)}_hull_00", "table_hull_00")),
    ],
    "bullet": [
        lambda b: hull(b / f"urdf/{first(b)}").unlink(),
        lambda b: edit_text(b / f"urdf/{first(b)}/{first(b)}.urdf", lambda t: t.replace('<mass value="', '<mass value="1')),
        lambda b: edit_text(b / "urdf/scene.urdf", lambda t: t.replace("</robot>", "")),
    ],
    "sdf": [
        lambda b: edit_text(b / "sdf/world.sdf", lambda t: t.replace("<mass>", "<mass>1", 1)),
        lambda b: edit_text(model(b), lambda t: t.replace("<inertial>", "<inertial><!--").replace("</inertial>", "--></inertial>")),
        lambda b: edit_text(b / "sdf/world.sdf", lambda t: t.replace(f'<model name="{first(b)}">', '<model name="nobody">')),
        lambda b: hull(model(b).parent).unlink(),
        lambda b: edit_text(b / "sdf/world.sdf", lambda t: t.replace("</world>", "")),
    ],
    "glb": [
        lambda b: edit_glb(b / f"glb/{first(b)}.glb", index_out_of_range),
        lambda b: edit_glb(b / "glb/scene.glb", lambda d: d["nodes"][1].update(translation=[0, 0, 1])),
        lambda b: edit_glb(b / f"glb/{first(b)}.glb", lambda d: d["nodes"][0].update(scale=[2, 2, 2])),
    ],
    "marks": [
        lambda b: edit_scene(b, lambda s: s["instances"][0].update(stand_in=True)),
        lambda b: edit_scene(b, lambda s: s["instances"][0].update(label="another")),
        lambda b: edit_text(b / "urdf/scene.urdf", lambda t: t.replace(f'link="{first(b)}"', f'link="{first(b)}" stand_in="true"', 1)),
        lambda b: edit_text(b / "sdf/world.sdf", lambda t: t.replace("<sdf ", '<sdf xmlns:t="https://tabletopgen.invalid/label/1" ').replace(f'<model name="{first(b)}"', f'<model t:stand_in="true" name="{first(b)}"')),
        lambda b: edit_text(b / "mjcf/scene.xml", lambda t: t.replace("</custom>", f'<text name="stand_in_{first(b)}" data="true"/></custom>')),
        lambda b: edit_glb(b / f"glb/{first(b)}.glb", lambda d: d["nodes"][0].update(extras={"stand_in": True})),
        lambda b: edit_prop(b, marked_as_stand_in),
    ],
    "collisions": [one_on_the_other, lambda b: edit_glb(b / f"glb/{first(b)}.glb", hole)],
    "readme": [lambda b: edit_text(b / "README.md", lambda t: t.replace("mjcf/scene.xml", "mjcf/none.xml"))],
}


def prop(bundle):
    return next((bundle / f"usd/assets/{first(bundle)}/simready_usd").glob("*.usd*"))


def edit_prop(bundle, change):
    layer = Sdf.Layer.FindOrOpen(str(prop(bundle)))
    before = layer.ExportToString()
    change(layer)
    assert before != layer.ExportToString(), f"the change leaves {prop(bundle)} as it was"
    layer.Save()


def edit_attributes(bundle, name, change):
    """Changes every attribute of that name in the first prop."""

    def edit(layer):
        paths = []
        layer.Traverse("/", paths.append)
        for path in paths:
            if path.IsPrimPropertyPath() and path.name == name:
                change(layer.GetAttributeAtPath(path))

    edit_prop(bundle, edit)


def without_binding_schema(layer):
    parts = layer.GetPrimAtPath(f"/{layer.defaultPrim}/visual").nameChildren
    parts[0].ClearInfo("apiSchemas")


def without_provenance(layer):
    metadata = dict(layer.customLayerData)
    metadata["SimReady_Metadata"] = {k: v for k, v in metadata["SimReady_Metadata"].items() if k != "qcode"}
    layer.customLayerData = metadata


def marked_as_stand_in(layer):
    attribute = Sdf.AttributeSpec(layer.GetPrimAtPath(f"/{layer.defaultPrim}"), "tabletopgen:stand_in", Sdf.ValueTypeNames.Bool)
    attribute.default = True


def cut(path, share):
    """Leaves the beginning of a file."""
    whole = path.read_bytes()
    path.write_bytes(whole[: int(len(whole) * share)])


def model(bundle):
    return bundle / f"sdf/models/{first(bundle)}/model.sdf"


def solid(mesh, at=(0, 0, 0)):
    pose = np.eye(4)
    pose[:3, 3] = at
    found, reason = solids.solid_of(mesh.vertices, mesh.faces, pose)
    assert found, reason
    return found


def check_depths():
    """Known depths: 1 mm counts in thick solids, a quarter of the wall in thin ones, insides always."""
    block = trimesh.creation.box((0.1, 0.1, 0.1))
    plate = trimesh.creation.box((0.1, 0.1, 0.002))
    ball = trimesh.creation.icosphere(subdivisions=3, radius=0.01)
    cup = trimesh.creation.annulus(0.02, 0.025, 0.08)
    pair = trimesh.util.concatenate([block, block.copy().apply_translation((0.06, 0.02, 0.03))])
    touching = trimesh.util.concatenate([block, block.copy().apply_translation((0.1, 0.1, 0))])
    turned = block.copy().apply_transform(trimesh.transformations.rotation_matrix(0.7, (0, 0, 1)))
    cases = [
        ("blocks 0.5 mm deep only touch", block, block, (0, 0, 0.0995), False),
        ("blocks 2 mm deep collide", block, block, (0, 0, 0.098), True),
        ("blocks apart", block, block, (0, 0, 0.11), False),
        ("a plate of 2 mm entered by 0.3 mm only touches", block, plate, (0, 0, 0.0507), False),
        ("a plate of 2 mm entered by 0.8 mm collides", block, plate, (0, 0, 0.0502), True),
        ("a ball in a tube does not collide", cup, ball, (0, 0, 0), False),
        ("a ball in the tube's wall does", cup, ball, (0.015, 0, 0), True),
        ("a ball inside a block is contained", block, ball, (0, 0, 0), True),
        ("a block in its own place is contained", block, block, (0, 0, 0), True),
        ("a ball inside two shells that overlap is contained", pair, ball, (0.03, 0.01, 0.015), True),
        ("a ball 0.5 mm inside two shells that overlap only touches", pair, ball, (0.03, 0.01, -0.0595), False),
        ("a ball between shells that share an edge collides", touching, ball, (0.05, 0.05, 0), True),
        ("a turned block on a block touches", block, turned, (0, 0, 0.1 - 2e-4), False),
        ("a plate pushed into a ball's side collides", ball, plate, (0.05, 0, 0.009), True),
    ]
    for what, a, b, at, expected in cases:
        depth = collisions.collision_depth(solid(a), solid(b, at))
        assert (depth is not None) == expected, f"{what}: depth {depth}"
    return len(cases)


def judged(name, bundle):
    """Half a second of what takes long; a body that is lifted falls within a fifth."""
    return importlib.import_module(name).judge(bundle, **({"duration_s": 0.5} if name in SLOW else {}))


def main():
    good = Path(sys.argv[1]).resolve()
    asked = [name for name in BREAKS if name not in LEFT_OUT]
    for name in asked:
        verdict = judged(name, good)
        assert verdict.accepted, f"{name} rejects the good bundle: {verdict.complaints}"
    broken = 0
    for name in asked:
        for k, spoil in enumerate(BREAKS[name]):
            with tempfile.TemporaryDirectory() as folder:
                bundle = Path(folder) / "bundle"
                shutil.copytree(good, bundle)
                spoil(bundle)
                try:
                    accepted = judged(name, bundle).accepted
                except Exception:
                    accepted = False  # judge.py counts an exception as a rejection
                assert not accepted, f"{name} accepts break {k}"
                broken += 1
    with tempfile.TemporaryDirectory() as folder:
        bundle = Path(folder) / "bundle"
        shutil.copytree(good, bundle)
        lifted(bundle)
        for name in [name for name in ("mjcf", "bullet") if name in asked]:
            verdict = judged(name, bundle)
            falls = verdict.facts["stable"] < verdict.facts["movable"]
            assert verdict.accepted and falls, f"a falling body counts as stable: {verdict}"
    without = f", without {', '.join(LEFT_OUT)}" if LEFT_OUT else ""
    checks = f"tell all {check_depths()} depths and {check_layouts(good)} layouts"
    print(f"the judges reject all {broken} broken bundles and {checks}{without}")


if __name__ == "__main__":
    main()

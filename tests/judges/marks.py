"""Every format tells the label of every body and marks the stand-ins of scene.json, and no other body."""

import json
import struct
from pathlib import Path
from xml.etree import ElementTree

import mujoco
from pxr import Usd

from verdict import Verdict, bodies, read_scene

OWN = "{https://tabletopgen.invalid/label/1}"


def judge(bundle: Path) -> Verdict:
    verdict = Verdict("marks")
    scene = read_scene(bundle)
    wanted = {body["name"]: mark(body.get) for body in bodies(scene) if body.get("stand_in")}
    labels = {body["name"]: held(body["label"]) for body in bodies(scene)}
    for path, (labeled, marked) in read(bundle, labels).items():
        for name, label in labeled.items():
            # MuJoCo refuses empty text: there the name stands for an empty label.
            if label not in (labels[name], labels[name] or name):
                verdict.complaints.append(f"{path}: the label of {name} is {label!r}, not {labels[name]!r}")
        expected = {name: wanted[name] for name in wanted if name in labeled}
        if marked != expected:
            verdict.complaints.append(f"{path} marks {marked} as stand-ins, not {expected}")
    verdict.facts = {"stand_ins": len(wanted)}
    return verdict


def mark(part):
    """The noun that was asked for, and what stands there."""
    return tuple(held(part(name) or "") for name in ("stands_for", "shown_as"))


def held(words):
    """XML and USD have no way to hold some control characters."""
    def bad(c):
        return c < " " and c not in "\t\n\r" or c in "\ufffe\uffff"
    return "".join("\ufffd" if bad(c) else c for c in words)


def read(bundle, labels):
    """Labels of the bodies that each file describes, and the names that it marks, by path."""
    found = {"mjcf/scene.xml": mjcf(bundle / "mjcf/scene.xml"), "urdf/scene.urdf": urdf(bundle / "urdf/scene.urdf")}
    world = ElementTree.parse(bundle / "sdf/world.sdf").getroot()
    found["sdf/world.sdf"] = ({model.get("name"): labels.get(model.get("name"), "") for model in world.iter("model")}, sdf(world))
    found["sdf/world.sdf"][0].pop("floor", None)
    stage = Usd.Stage.Open(str(next((bundle / "usd").glob("scene.usd*"))))
    found["usd"] = usd(stage, labels)
    found["glb/scene.glb"] = glb(bundle / "glb/scene.glb", labels)
    for name in labels:
        path = f"urdf/{name}/{name}.urdf"
        found[path] = urdf(bundle / path)
        folder = bundle / "sdf" / "models" / name
        description = ElementTree.parse(folder / "model.config").getroot().findtext("description")
        found[f"sdf/models/{name}"] = ({name: description}, sdf(ElementTree.parse(folder / "model.sdf").getroot()))
        path = f"glb/{name}.glb"
        extras = next((node["extras"] for node in nodes(bundle / path) if "extras" in node), {})
        found[path] = ({name: extras.get("label", labels[name])}, {name: mark(extras.get)} if extras.get("stand_in") else {})
        path = f"mjcf/{name}/{name}.xml"
        if (bundle / path).is_file():
            labeled, marked = mjcf(bundle / path)
            found[path] = (labeled or {name: labels[name]}, marked)
    return found


def mjcf(path):
    model = mujoco.MjSpec.from_file(str(path))
    texts = {text.name: text.data for text in model.texts}
    def of(prefix):
        return {name.removeprefix(prefix): data for name, data in texts.items() if name.startswith(prefix)}
    marked = [name for name, data in of("stand_in_").items() if data == "true"]
    return of("label_"), {name: mark(lambda part, name=name: texts.get(f"{part}_{name}")) for name in marked}


def urdf(path):
    elements = ElementTree.parse(path).getroot().findall(f"{OWN}label")
    marked = {element.get("link"): mark(element.get) for element in elements if element.get("stand_in") == "true"}
    return {element.get("link"): element.get("text") for element in elements}, marked


def sdf(root):
    def of(model):
        return mark(lambda part: model.get(f"{OWN}{part}"))
    return {model.get("name"): of(model) for model in root.iter("model") if model.get(f"{OWN}stand_in") == "true"}


def usd(stage, labels):
    prims = {name: stage.GetDefaultPrim().GetChild(name) for name in labels}
    def attributes_of(prim):
        return lambda part: prim.GetAttribute(f"tabletopgen:{part}").Get()
    marked = {name: mark(attributes_of(prim)) for name, prim in prims.items() if attributes_of(prim)("stand_in")}
    return {name: held(prim.GetDisplayName()) for name, prim in prims.items()}, marked


def glb(path, labels):
    extras_by_name = {node["name"]: node.get("extras", {}) for node in nodes(path) if node.get("name") in labels}
    marked = {name: mark(extras.get) for name, extras in extras_by_name.items() if extras.get("stand_in") is True}
    return {name: held(extras.get("label", "")) for name, extras in extras_by_name.items()}, marked


def nodes(path):
    data = path.read_bytes()
    (length,) = struct.unpack_from("<I", data, 12)
    return json.loads(data[20 : 20 + length])["nodes"]

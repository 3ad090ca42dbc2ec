"""The collision shapes of a body, as its URDF tells them: meshes, boxes, cylinders and spheres at their places."""

from dataclasses import dataclass
from math import pi, prod
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from scipy.spatial.transform import Rotation


@dataclass
class Shape:
    kind: str
    """`mesh`, `box`, `cylinder` or `sphere`."""
    sizes: list
    """Meters: the sides of a box; radius and length of a cylinder; the radius of a sphere."""
    position: np.ndarray
    rotation: Rotation
    path: Path | None
    """The file of a mesh."""

    def volume(self) -> float:
        """Of what is no mesh."""
        if self.kind == "box":
            return prod(self.sizes)
        if self.kind == "cylinder":
            return pi * self.sizes[0] ** 2 * self.sizes[1]
        return 4 / 3 * pi * self.sizes[0] ** 3


def shapes(bundle: Path, name: str) -> list:
    path = bundle / "urdf" / name / f"{name}.urdf"
    return [read(collision, path.parent) for collision in ElementTree.parse(path).getroot().iter("collision")]


def read(collision, folder: Path) -> Shape:
    origin, (shape,) = collision.find("origin"), collision.find("geometry")
    def numbers(element, key):
        return [float(part) for part in element.get(key).split()]
    turn = Rotation.from_euler("xyz", numbers(origin, "rpy"))
    keys = {"mesh": [], "box": ["size"], "cylinder": ["radius", "length"], "sphere": ["radius"]}[shape.tag]
    sizes = [size for key in keys for size in numbers(shape, key)]
    file = folder / shape.get("filename") if shape.tag == "mesh" else None
    return Shape(shape.tag, sizes, np.array(numbers(origin, "xyz")), turn, file)

"""Colors and materials of a body, from the MJCF file of its bundle: every part with its area and its mean color."""

import math
import struct
import xml.etree.ElementTree as ElementTree
import zlib
from dataclasses import dataclass
from pathlib import Path


@dataclass
class Part:
    """The surface of one material."""

    material: str
    area_m2: float
    # sRGB, channels from 0 to 1.
    color: tuple


def parts(folder: Path, name: str) -> list:
    """The parts of the body `name`, the largest first."""
    root = ElementTree.parse(folder / "mjcf" / "scene.xml").getroot()
    assets = folder / "mjcf" / "assets"
    textures = {element.get("name"): element.get("file") for element in root.iter("texture")}
    materials = {element.get("name"): element for element in root.iter("material")}
    meshes = {element.attrib["name"]: element.attrib["file"] for element in root.iter("mesh")}
    found = []
    for geom in root.iter("geom"):
        if geom.get("name", "").startswith(f"{name}_visual_") and geom.get("material"):
            material = materials[geom.attrib["material"]]
            color = tuple(map(float, material.get("rgba", "1 1 1 1").split()))[:3]
            if texture := textures.get(material.get("texture")):
                color = tuple(a * b for a, b in zip(color, mean_color(assets / texture)))
            area_m2 = mesh_area_m2(assets / meshes[geom.attrib["mesh"]])
            found.append(Part(material.attrib["name"].removeprefix(f"{name}_"), area_m2, color))
    return sorted(found, key=lambda part: -part.area_m2)


def mesh_area_m2(path: Path) -> float:
    points, area = [], 0.0
    for line in path.read_text(encoding="utf-8").splitlines():
        if line.startswith("v "):
            points.append(tuple(map(float, line.split()[1:4])))
        elif line.startswith("f "):
            a, b, c = (points[int(corner.split("/")[0]) - 1] for corner in line.split()[1:4])
            u, v = ([q[k] - a[k] for k in range(3)] for q in (b, c))
            normal = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
            area += 0.5 * math.hypot(*normal)
    return area


def mean_color(path: Path) -> tuple:
    """Mean of an 8-bit PNG without interlacing."""
    data, offset, packed, head = path.read_bytes(), 8, b"", (0,) * 7
    while offset < len(data):
        length, kind = struct.unpack(">I4s", data[offset : offset + 8])
        content = data[offset + 8 : offset + 8 + length]
        if kind == b"IHDR":
            head = struct.unpack(">IIBBBBB", content)
        elif kind == b"IDAT":
            packed += content
        offset += 12 + length
    width, height, bits, color_type, *_, interlaced = head
    channels = {0: 1, 2: 3, 4: 2, 6: 4}.get(color_type)
    if bits != 8 or channels is None or interlaced:
        raise ValueError(f"{path} is no 8-bit PNG of gray or color")
    raw, stride = zlib.decompress(packed), width * channels
    row, sums = bytearray(stride), [0] * channels
    for k in range(height):
        start = k * (stride + 1)
        row = unfiltered(raw[start], raw[start + 1 : start + 1 + stride], row, channels)
        sums = [total + sum(row[channel::channels]) for channel, total in enumerate(sums)]
    means = [total / (255.0 * width * height) for total in sums]
    return tuple(means[:3]) if channels >= 3 else (means[0],) * 3


def unfiltered(kind: int, line: bytes, above: bytearray, step: int) -> bytearray:
    """One row of a PNG, by the filters of its specification."""
    row = bytearray(line)
    if kind == 0:
        return row
    for k in range(len(row)):
        left = row[k - step] if k >= step else 0
        up, corner = above[k], above[k - step] if k >= step else 0
        if kind == 1:
            guess = left
        elif kind == 2:
            guess = up
        elif kind == 3:
            guess = (left + up) // 2
        else:
            away = [abs(up - corner), abs(left - corner), abs(left + up - 2 * corner)]
            guess = (left, up, corner)[away.index(min(away))]
        row[k] = (row[k] + guess) & 255
    return row

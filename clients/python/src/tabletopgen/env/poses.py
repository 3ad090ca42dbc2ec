"""Poses as matrices of 4 by 4, meters, and the numbers that files and datasets state them with."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tabletopgen.env.engine import mujoco

Array = NDArray[np.float64]


def rotations(quaternions_wxyz: ArrayLike) -> Array:
    """Matrices of unit quaternions, (..., 4) to (..., 3, 3)."""
    w, x, y, z = np.moveaxis(np.asarray(quaternions_wxyz, dtype=float), -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def transform(position_m: ArrayLike, quaternion_wxyz: ArrayLike) -> Array:
    """The matrix of a position and a unit quaternion."""
    return with_rotation(position_m, rotations(quaternion_wxyz))


def with_rotation(position_m: ArrayLike, rotation: ArrayLike) -> Array:
    """The matrix of a position and a rotation's matrix."""
    whole = np.eye(4)
    whole[:3, :3], whole[:3, 3] = np.reshape(rotation, (3, 3)), position_m
    return whole


def inverse(pose: Array) -> Array:
    """The inverse of a rigid transformation."""
    rotation = pose[:3, :3].T
    return with_rotation(-rotation @ pose[:3, 3], rotation)


def of_record(record: Mapping[str, Any]) -> Array:
    """The matrix of `translation_m` and `rotation_xyzw`."""
    x, y, z, w = record["rotation_xyzw"]
    return transform(record["translation_m"], [w, x, y, z])


def to_record(pose: Array) -> dict[str, list[float]]:
    """`translation_m` and `rotation_xyzw` of a matrix."""
    w, x, y, z = quaternion_wxyz(pose[:3, :3]).tolist()
    return {"translation_m": pose[:3, 3].tolist(), "rotation_xyzw": [x, y, z, w]}


def quaternion_wxyz(rotation: ArrayLike) -> Array:
    """One of the two unit quaternions of a rotation's matrix."""
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(rotation, dtype=float).ravel())
    return quaternion


def of_rotation_vector(vector_rad: Sequence[float]) -> Array:
    """The rotation's matrix of an axis times an angle."""
    angle_rad = float(np.linalg.norm(vector_rad))
    quaternion, matrix = np.zeros(4), np.zeros(9)
    axis = np.asarray(vector_rad, dtype=float) / angle_rad if angle_rad > 0 else np.array([0.0, 0.0, 1.0])
    mujoco.mju_axisAngle2Quat(quaternion, axis, angle_rad)
    mujoco.mju_quat2Mat(matrix, quaternion)
    return matrix.reshape(3, 3)


def rotation_of_columns(first: ArrayLike, second: ArrayLike) -> Array:
    """The rotation whose first two columns are nearest to these directions: the first one is kept, of the second one
    what is perpendicular. Raises `ValueError` for directions that are parallel or zero."""
    x = np.asarray(first, dtype=float)
    x_norm = float(np.linalg.norm(x))
    y = np.asarray(second, dtype=float)
    if x_norm > 0:
        x = x / x_norm
        y = y - (x @ y) * x
    y_norm = float(np.linalg.norm(y))
    if not (x_norm > 1e-6 and y_norm > 1e-6):
        raise ValueError(f"{list(map(float, x))} and {list(map(float, y))} are no columns of a rotation; give two that are not parallel")
    y = y / y_norm
    return np.stack([x, y, np.cross(x, y)], axis=1)

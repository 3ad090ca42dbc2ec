"""Models of Pinocchio."""

from importlib import metadata

import numpy as np
import pinocchio


def load_published_panda() -> pinocchio.Model:
    """That of PyPI's example-robot-data, wherever the package puts it."""
    files = metadata.files("example-robot-data") or []
    found = [file.locate() for file in files if file.name == "panda.urdf"]
    if len(found) != 1:
        raise FileNotFoundError(f"example-robot-data has {len(found)} files named panda.urdf")
    return pinocchio.buildModelFromUrdf(str(found[0]))


def joint_vector(model: pinocchio.Model, named: dict) -> np.ndarray:
    """The configuration with the named positions; every joint of the model must be named."""
    vector = pinocchio.neutral(model)
    for index, name in enumerate(model.names):
        if index > 0:
            vector[model.joints[index].idx_q] = named[name]
    return vector

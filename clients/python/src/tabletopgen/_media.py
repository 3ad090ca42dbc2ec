"""Objects for the bytes of an artifact, by its media type."""

from __future__ import annotations

import importlib
import io
import json
from typing import Any

from tabletopgen.errors import MissingPackageError


def imported(module: str, package: str | None = None) -> Any:
    """A module of an optional package."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        name = package or module
        raise MissingPackageError(f"this needs the package {name}: pip install {name} ({error})") from error


def opened(content: bytes, media_type: str) -> Any:
    """JSON as values, text as a string, an image as that of Pillow, a mesh as that of trimesh, others as bytes."""
    kind = media_type.partition(";")[0].strip()
    if kind == "application/json":
        return json.loads(content)
    if kind.startswith("image/"):
        return imported("PIL.Image", "pillow").open(io.BytesIO(content))
    if kind == "model/gltf-binary":
        return imported("trimesh").load(io.BytesIO(content), file_type="glb")
    if kind.startswith("text/"):
        return content.decode()
    return content

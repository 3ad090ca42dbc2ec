"""MuJoCo, imported once for this package. Without a display it draws by EGL, unless `MUJOCO_GL` says otherwise."""

from __future__ import annotations

import os
import sys
from typing import Any

from tabletopgen._media import imported

# MuJoCo reads the variable when it is imported.
if sys.platform == "linux" and not os.environ.get("DISPLAY"):
    os.environ.setdefault("MUJOCO_GL", "egl")

mujoco: Any = imported("mujoco")

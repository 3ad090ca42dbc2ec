"""The model of an environment: its file, and the cameras of its observations."""

from __future__ import annotations

from typing import Any

from tabletopgen.env.cameras import name_of
from tabletopgen.env.engine import mujoco
from tabletopgen.env.folder import EnvironmentFolder

# The camera of the image that the scene was made from, or one that shows it from the front.
OVERVIEW = "reference_camera"
# Width and height of what it sees.
RENDER_PX = (640, 480)
SHADOW_PX = 1024


def compiled(files: EnvironmentFolder) -> Any:
    """The `mujoco.MjModel`, with room for all images."""
    spec = mujoco.MjSpec.from_file(str(files.mjcf))
    (tool,) = (site for site in spec.sites if site.name.startswith(files.robot.prefix))
    for camera in files.cameras:
        body = spec.worldbody if camera.mount == "world" else tool.parent
        body.add_camera(name=name_of(camera))
    room = spec.visual.global_
    room.offwidth = max([room.offwidth, RENDER_PX[0], *(camera.width_px for camera in files.cameras)])
    room.offheight = max([room.offheight, RENDER_PX[1], *(camera.height_px for camera in files.cameras)])
    # Maps of 4096 pixels, MuJoCo's default, take most of the time of an image where a CPU draws it.
    spec.visual.quality.shadowsize = SHADOW_PX
    return spec.compile()

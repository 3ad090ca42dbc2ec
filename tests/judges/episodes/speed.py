"""What other renderers need for the images of a scene with its robot: CPU seconds of this process, all threads.

    speed.py MJCF [IMAGES]

MuJoCo's renderer (MUJOCO_GL chooses EGL or OSMesa) draws cameras of 224 x 224 pixels around the scene, in turn, at
poses of the arm that change between images; Embree (PyPI `embreex`) finds the first triangle at every pixel of the same
cameras, with the triangles of the visible geometry, built anew for each pose as the arm moves. Prints one line of JSON
with milliseconds an image.
"""

import json
import sys
import time

import mujoco
import numpy as np

SIDE_PX, FOV_RAD = 224, 0.9
# Azimuth and elevation of the cameras, degrees, and their distance from the center of the table's top, meters.
VIEWS = ((90.0, -30.0), (180.0, -37.0), (135.0, -60.0))
DISTANCE_M = 0.95


def main(path: str, images: int) -> int:
    model = mujoco.MjModel.from_xml_path(path)
    model.vis.global_.fovy = np.degrees(FOV_RAD)
    data = mujoco.MjData(model)
    result = {"images": images, "triangles": int(sum(len(part) for part in triangles_of(model, moved(model, data, 0))))}
    result["mujoco_ms"] = mujoco_ms(model, data, images)
    result["embree_ms"] = embree_ms(model, data, images)
    print(json.dumps(result))
    return 0


def moved(model, data, step: int):
    """The scene with the arm a little farther each time."""
    mujoco.mj_resetData(model, data)
    for number in range(model.njnt):
        if model.jnt_type[number] == mujoco.mjtJoint.mjJNT_HINGE:
            low, high = model.jnt_range[number]
            data.qpos[model.jnt_qposadr[number]] = low + (high - low) * (0.4 + 0.002 * (step % 100))
    mujoco.mj_forward(model, data)
    return data


def mujoco_ms(model, data, images: int) -> float:
    with mujoco.Renderer(model, SIDE_PX, SIDE_PX) as renderer:
        camera = mujoco.MjvCamera()
        camera.distance, camera.lookat = DISTANCE_M, np.zeros(3)

        def draw(step: int):
            camera.azimuth, camera.elevation = VIEWS[step % len(VIEWS)]
            renderer.update_scene(moved(model, data, step // len(VIEWS)), camera)
            return renderer.render()

        assert len(np.unique(draw(0).reshape(-1, 3), axis=0)) > 100, "the image is empty"
        return per_image_ms(draw, images)


def embree_ms(model, data, images: int) -> float:
    from embreex.mesh_construction import TriangleMesh
    from embreex.rtcore_scene import EmbreeScene

    scenes, rays = {}, [rays_of(*view) for view in VIEWS]

    def find(step: int):
        pose = step // len(VIEWS)
        if pose not in scenes:
            scenes.clear()
            scene = EmbreeScene()
            triangles = np.concatenate(triangles_of(model, moved(model, data, pose))).astype(np.float32)
            scenes[pose] = (scene, TriangleMesh(scene, triangles))
        origins, directions = rays[step % len(VIEWS)]
        return scenes[pose][0].run(origins, directions)

    assert (find(0) >= 0).mean() > 0.2, "the rays meet nothing"
    return per_image_ms(find, images)


def per_image_ms(draw, images: int) -> float:
    began = time.process_time()
    for step in range(images):
        draw(step)
    return 1e3 * (time.process_time() - began) / images


def rays_of(azimuth_deg: float, elevation_deg: float) -> tuple:
    """Origins and directions of the rays through the centers of the pixels, as MuJoCo's camera has them."""
    azimuth, elevation = np.radians([azimuth_deg, elevation_deg])
    forward = np.array([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)])
    right = np.cross(forward, [0, 0, 1])
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    steps = np.tan(FOV_RAD / 2) * (2 * (np.arange(SIDE_PX) + 0.5) / SIDE_PX - 1)
    directions = (forward + steps[None, :, None] * right - steps[:, None, None] * up).reshape(-1, 3)
    origins = np.broadcast_to(-DISTANCE_M * forward, directions.shape)
    return np.ascontiguousarray(origins, np.float32), np.ascontiguousarray(directions, np.float32)


def triangles_of(model, data) -> list:
    """Triangles in the world of the meshes that are drawn by default."""
    parts = []
    for geom in range(model.ngeom):
        if model.geom_type[geom] != mujoco.mjtGeom.mjGEOM_MESH or model.geom_group[geom] > 2:
            continue
        mesh = model.geom_dataid[geom]
        first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
        points = model.mesh_vert[first : first + count] @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom]
        first, count = model.mesh_faceadr[mesh], model.mesh_facenum[mesh]
        parts.append(points[model.mesh_face[first : first + count]])
    return parts


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    sys.exit(main(sys.argv[1], int(sys.argv[2]) if len(sys.argv) == 3 else 60))

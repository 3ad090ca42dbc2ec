"""h5py reads the file by the layout that robomimic documents."""

import json

import h5py
import numpy as np

import scene
from complaints import Complaints


def judge(folder) -> tuple:
    complaints = Complaints()
    with h5py.File(folder / "robomimic/dataset.hdf5") as file:
        data = file["data"]
        complaints.equal("total", int(data.attrs["total"]), scene.total_frames())
        arguments = json.loads(data.attrs["env_args"])
        complaints.equal("keys of env_args", set(arguments), {"env_name", "env_type", "env_kwargs"})
        names = {f"demo_{episode}" for episode in range(scene.EPISODES)}
        complaints.equal("episodes", set(data), names)
        complaints.equal("training", {name.decode() for name in file["mask/train"][:]}, names)
        successes = {name.decode() for name in file["mask/success"][:]}
        complaints.equal("successes", successes, names - {f"demo_{scene.FAILED}"})
        for episode in range(scene.EPISODES):
            demo(data[f"demo_{episode}"], episode, complaints)
    return complaints.facts(), complaints.texts


def demo(group, episode: int, complaints: Complaints) -> None:
    frames, name = scene.frames(episode), group.name
    states, actions = scene.states(episode), scene.actions(episode)
    complaints.equal(f"{name} frames", int(group.attrs["num_samples"]), frames)
    complaints.equal(f"{name} seed", int(group.attrs["seed"]), 1000 + episode)
    complaints.equal(f"{name} record", json.loads(group.attrs["record"])["number"], episode)
    complaints.equal(f"{name} targets", group["action_targets"][:], actions)
    scaled = np.stack([actions[:, 0] / 2, 2 * actions[:, 1] - 1], 1)
    complaints.equal(f"{name} actions", group["actions"][:], scaled.astype(np.float32))
    complaints.equal(f"{name} actions in [-1, 1]", bool((np.abs(group["actions"][:]) <= 1).all()), True)
    complaints.equal(f"{name} servo commands", group["servo_commands"][:], scene.servo_commands(episode))
    complaints.equal(f"{name} states", group["states"][:], states)
    last = np.arange(frames) == frames - 1
    complaints.equal(f"{name} dones", group["dones"][:].astype(bool), last)
    rewards = last.astype(np.float32) * (episode != scene.FAILED)
    complaints.equal(f"{name} rewards", group["rewards"][:], rewards.astype(np.float32))
    obs = group["obs"]
    complaints.equal(f"{name} rotation", obs["end_effector_rotation"][:], states[:, 6:10])
    complaints.equal(f"{name} rotation of six numbers", obs["end_effector_rotation_6d"][:], states[:, 10:])
    following = np.concatenate([states[1:], states[-1:]])
    complaints.equal(f"{name} next gripper", group["next_obs/gripper"][:], following[:, 1:2])
    complaints.equal(f"{name} depth", obs["front_depth"][:][..., 0], np.stack([scene.depth_m()] * frames))
    complaints.equal(f"{name} no depth", "wrist_depth" in obs, False)
    clouds = [np.stack(of_frames) for of_frames in zip(*(scene.points(episode, t) for t in range(frames)), strict=True)]
    for key, cloud in zip(("point_cloud", "point_cloud_colors", "point_cloud_ids"), clouds, strict=True):
        complaints.equal(f"{name} {key}", obs[key][:].astype(cloud.dtype), cloud)
    for camera in scene.CAMERAS:
        images = np.stack([scene.image(episode, t) for t in range(frames)])
        complaints.equal(f"{name} {camera} image", obs[f"{camera}_image"][:], images)
        complaints.equal(f"{name} {camera} type", str(obs[f"{camera}_image"].dtype), "uint8")
        ids = np.stack([scene.instance_ids(episode, t, camera) for t in range(frames)])
        complaints.equal(f"{name} {camera} ids", obs[f"{camera}_instance_ids"][:].astype(np.uint32), ids)
        poses = np.stack([scene.world_from_camera(t, camera) for t in range(frames)])
        complaints.equal(f"{name} {camera} pose", obs[f"{camera}_world_from_camera"][:], poses)
        complaints.equal(f"{name} {camera} K", obs[f"{camera}_intrinsics"][:], np.stack([scene.INTRINSICS] * frames))

"""Targets of servos that bring the arm to where actions ask it to be."""

from __future__ import annotations

import numpy as np

from tabletopgen.env.poses import Array
from tabletopgen.env.robot import Robot

# What held weights leave of an error is taken up in this time, by so much torque and so far at most: more would press
# on what the arm cannot move. Faster, weak servos swing.
TAKEN_UP_S, MAX_TORQUE_NM, MAX_RAD = 0.2, 6.0, 0.15
# Joints that are slower than this feel less than their whole friction, so that it does not jump at rest.
SLOW_RAD_S = 0.05


class Tracking:
    """The servos of the arm in one episode, step by step."""

    def __init__(self, robot: Robot, step_s: float):
        self.robot, self.step_s = robot, step_s
        self.share = 1.0 - np.exp(-step_s / TAKEN_UP_S)
        self.max_rad = np.minimum(MAX_TORQUE_NM / robot.stiffness_nm_rad, MAX_RAD)
        self.begin(np.zeros(len(robot.arm_qpos)))

    def begin(self, positions_rad: Array) -> None:
        """Begins where the arm rests."""
        self.asked_rad: Array = positions_rad.copy()
        self._taken_up_rad = np.zeros_like(self.asked_rad)

    def targets(self, asked_rad: Array, measured_rad: Array) -> Array:
        """Positions that the servos pull to, to be at these at the end of the step: ahead by what damping and friction
        hold back, and by what was missing at the end of the steps before."""
        missing_rad = self.asked_rad - measured_rad
        self._taken_up_rad = np.clip(self._taken_up_rad + self.share * missing_rad, -self.max_rad, self.max_rad)
        speed_rad_s = (asked_rad - self.asked_rad) / self.step_s
        self.asked_rad = asked_rad
        friction_rad = np.tanh(speed_rad_s / SLOW_RAD_S) * self.robot.friction_nm / self.robot.stiffness_nm_rad
        ahead: Array = asked_rad + self.robot.lag_s * speed_rad_s + friction_rad + self._taken_up_rad
        return ahead

"""Compares the time law of crate `robot` with that of the library toppra, on the same curves.

    PYTHONPATH=python python -m tabletopgen_checks.robots.planning_timing [--folder target/robot_planning] [--count 100]

Reads `problems.json` and `solutions.json`, as `robot_planning_bar.py` leaves them, and needs `pip install toppra`.
Each path becomes the cubic B-spline of `trajectory::Curve`; toppra times it within the same limits of velocity and
acceleration. The bar: no duration differs by more than 1 percent.
"""

import argparse
import json
import math
import sys
from pathlib import Path

import numpy
import scipy.interpolate
import toppra
import toppra.algorithm
import toppra.constraint

SPACING = 0.1
MAX_DIFFERENCE = 0.01
GRID_POINTS_PER_SPAN = 6


class UniformSpline(toppra.interpolator.AbstractGeometricPath):
    """The uniform cubic B-spline whose control points lie on a path.

    Its parameter is about the length of the path: toppra's solver fails on derivatives that are far from 1.
    """

    def __init__(self, path):
        controls = [numpy.array(path[0])]
        for begin, end in zip(map(numpy.array, path), map(numpy.array, path[1:])):
            count = math.ceil(numpy.linalg.norm(end - begin) / SPACING)
            controls += [begin + (end - begin) * k / count for k in range(1, count + 1)]
        self.span_count = len(controls) - 1
        controls = [2 * controls[0] - controls[1], *controls, 2 * controls[-1] - controls[-2]]
        self.spline = scipy.interpolate.BSpline(numpy.arange(-3, len(controls) + 1), numpy.array(controls), 3)

    def __call__(self, position, order=0):
        return self.spline(numpy.asarray(position) / SPACING, nu=order) / SPACING**order

    @property
    def dof(self):
        return self.spline.c.shape[1]

    @property
    def path_interval(self):
        return numpy.array([0.0, SPACING * self.span_count])

    @property
    def waypoints(self):
        return None


def duration_s(path, joints) -> float:
    spline = UniformSpline(path)
    bounds = [numpy.array([[-j[key], j[key]] for j in joints]) for key in ("max_velocity", "max_acceleration")]
    constraints = [
        toppra.constraint.JointVelocityConstraint(bounds[0]),
        toppra.constraint.JointAccelerationConstraint(
            bounds[1], discretization_scheme=toppra.constraint.DiscretizationType.Interpolation
        ),
    ]
    grid = numpy.linspace(0, SPACING * spline.span_count, GRID_POINTS_PER_SPAN * spline.span_count + 1)
    algorithm = toppra.algorithm.TOPPRA(constraints, spline, gridpoints=grid, solver_wrapper="seidel")
    _, rates, _ = algorithm.compute_parameterization(0, 0)
    return float(numpy.sum(2 * numpy.diff(grid) / (rates[1:] + rates[:-1])))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--folder", type=Path, default=Path("target/robot_planning"))
    parser.add_argument("--count", type=int, default=100)
    options = parser.parse_args()
    toppra.setup_logging("WARNING")
    joints = json.loads((options.folder / "problems.json").read_text())["arm"]["joints"]
    solutions = json.loads((options.folder / "solutions.json").read_text())
    solved = [s for s in solutions if s["outcome"] == "solved"]
    chosen = solved[:: max(1, len(solved) // options.count)]
    shares = [s["unfiltered_s"] / duration_s(s["path"], joints) for s in chosen]
    print(f"{len(shares)} paths: duration over that of toppra {min(shares):.5f} to {max(shares):.5f}")
    return 1 if max(abs(share - 1) for share in shares) > MAX_DIFFERENCE else 0


if __name__ == "__main__":
    sys.exit(main())

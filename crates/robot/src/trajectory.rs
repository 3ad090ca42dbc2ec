//! When a path is where: timing within the limits of velocity, acceleration and jerk.

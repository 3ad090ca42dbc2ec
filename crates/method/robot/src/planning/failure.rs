//! Failures of planning.

use crate::collision::Clearance;

/// Reason why a planner has no path. The variants and their codes are stable.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlanFailure {
    #[error("a configuration of the problem has {found} joints; the arm has {expected}")]
    WrongLength { found: usize, expected: usize },
    #[error("the start has joint {joint} at {position}, outside of its limits")]
    StartOutsideLimits { joint: usize, position: f64 },
    #[error("the start is in collision: {} m between {:?}", clearance.distance_m, clearance.between)]
    StartInCollision { clearance: Clearance },
    #[error("there is no configuration to plan to: no goal was given, or none reaches the wanted pose")]
    GoalUnreachable,
    #[error("every goal has a joint outside of its limits; the first one has joint {joint} at {position}")]
    GoalOutsideLimits { joint: usize, position: f64 },
    #[error("every goal is in collision; the first has {} m between {:?}", clearance.distance_m, clearance.between)]
    GoalInCollision { clearance: Clearance },
    #[error(
        "no path after {samples} samples with {nodes} nodes; raise the limits, or the goal cannot be reached"
    )]
    NoPath { samples: usize, nodes: usize },
    #[error("the straight motion stops {reached} of the way to its end: {obstacle}")]
    StraightMotionBlocked { reached: f64, obstacle: StraightMotionObstacle },
}

/// Obstacle of a straight motion of the tool.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StraightMotionObstacle {
    #[error("no configuration has the tool there")]
    OutOfReach,
    #[error("a joint is at its limit")]
    JointLimit,
    #[error("the arm touches something")]
    Collision,
    #[error("the arm would have to jump to another configuration")]
    Jump,
}

impl PlanFailure {
    /// A short name for statistics and files.
    pub fn code(&self) -> &'static str {
        match self {
            Self::WrongLength { .. } => "wrong_length",
            Self::StartOutsideLimits { .. } => "start_outside_limits",
            Self::StartInCollision { .. } => "start_in_collision",
            Self::GoalUnreachable => "goal_unreachable",
            Self::GoalOutsideLimits { .. } => "goal_outside_limits",
            Self::GoalInCollision { .. } => "goal_in_collision",
            Self::NoPath { .. } => "no_path",
            Self::StraightMotionBlocked { obstacle, .. } => match obstacle {
                StraightMotionObstacle::OutOfReach => "straight_motion_out_of_reach",
                StraightMotionObstacle::JointLimit => "straight_motion_joint_limit",
                StraightMotionObstacle::Collision => "straight_motion_collision",
                StraightMotionObstacle::Jump => "straight_motion_jump",
            },
        }
    }
}

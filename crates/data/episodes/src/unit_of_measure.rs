//! Units of the numbers in states and actions. They stand in the names that a dataset carries.

use serde::{Deserialize, Serialize};

/// The unit of one number. Its suffix ends the number's name in every format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Unit {
    Radians,
    RadiansPerSecond,
    Meters,
    MetersPerSecond,
    /// Opening of a gripper over its largest opening: 0 is closed, 1 is open.
    OpenFraction,
    /// One component of a unit quaternion. The name of the component is `qw`, `qx`, `qy` or `qz`.
    QuaternionComponent,
    /// A number without a unit.
    Dimensionless,
}

impl Unit {
    /// The end of the name of a number with this unit; empty where the name itself says it.
    pub fn suffix(self) -> &'static str {
        match self {
            Self::Radians => "_rad",
            Self::RadiansPerSecond => "_rad_per_s",
            Self::Meters => "_m",
            Self::MetersPerSecond => "_m_per_s",
            Self::OpenFraction => "_0_closed_1_open",
            Self::QuaternionComponent | Self::Dimensionless => "",
        }
    }

    /// Text for the table of features.
    pub fn text(self) -> &'static str {
        match self {
            Self::Radians => "rad",
            Self::RadiansPerSecond => "rad/s",
            Self::Meters => "m",
            Self::MetersPerSecond => "m/s",
            Self::OpenFraction => "0 closed, 1 open",
            Self::QuaternionComponent => "unit quaternion, w first",
            Self::Dimensionless => "1",
        }
    }
}

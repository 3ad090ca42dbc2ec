//! Contacts that a simulation reports.

use scene::InstanceId;
use serde::{Deserialize, Serialize};

/// One side of a contact.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ContactBody {
    Table,
    /// Fingers and palm.
    Gripper,
    Object(InstanceId),
}

/// Two bodies that touch.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Contact {
    pub first: ContactBody,
    pub second: ContactBody,
}

impl Contact {
    /// Whether it is between these two, in either order.
    pub fn is_between(&self, a: &ContactBody, b: &ContactBody) -> bool {
        (&self.first == a && &self.second == b) || (&self.first == b && &self.second == a)
    }
}

//! Jobs: retries, leases, restarts, outages.

mod lifecycle;
mod restarts;
mod leases;
mod outages;
mod drain;
mod single_flight;

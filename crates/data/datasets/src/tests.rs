//! Tests of whole datasets, made of small bundles in temporary folders.

mod fixture;
mod freezing;
mod grouping;
mod numbers;
mod verifying;
mod versions;

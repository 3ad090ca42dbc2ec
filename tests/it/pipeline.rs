//! Stages against scenes whose truth is known.

mod truth;
mod text_account;
mod features;
mod edit;
mod edited_text;
mod robot;
mod clutter;
mod instructions;

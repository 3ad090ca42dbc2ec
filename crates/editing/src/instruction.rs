//! Operations read from an English sentence.

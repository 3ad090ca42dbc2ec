//! Scenes painted from sentences show what the painter says they show.


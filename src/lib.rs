//! tabletopgen turns a sentence or one picture into a tabletop scene a robot can be trained in.
//!
//! The modules below stand in the order a scene travels. Read this file, then [`pipeline`], then one
//! stage, then the toolbox function it calls, and you have seen the program.

// What a person starts.
pub mod config;
pub mod app;
pub mod cli;

// 1. A request arrives.
pub mod api;

// 2. It becomes a job.
pub mod worker;

// 3. Stages turn it into a scene.
pub mod pipeline;

// 4. What stages speak about, to, and write.

// 5. The toolbox: meshes and numbers, nothing of jobs.

// 6. What survives a restart.

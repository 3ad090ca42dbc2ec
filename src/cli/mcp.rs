//! `mcp`: the commands as tools of the Model Context Protocol, over standard input and output.
//!
//! A tool runs the command of its name in a process of its own and answers with its JSON document, so an assistant gets
//! what a person gets. Scenes, tasks and recordings are folders below one folder, and tools know them by name alone: no
//! path of a model's choice is read or written.

mod folder;
mod command;
mod parameters;

use std::path::PathBuf;

use clap::Args;
use rmcp::handler::server::wrapper::Parameters;
use rmcp::model::{CallToolResult, ContentBlock, Implementation, ServerCapabilities, ServerConfig};
use rmcp::service::RequestContext;
use rmcp::{ErrorData, RoleServer, ServerHandler, ServiceExt, tool, tool_handler, tool_router};

use super::{Exit, Failure, block_on, execute};
use command::Command;
use folder::Folder;
use parameters::{Edit, Episodes, Execute, Generate, Inspect, Parse, Tasks, Variants};

/// Instructions that an assistant gets before its first call.
const INSTRUCTIONS: &str = "Makes tabletop scenes for robot simulation (USD, URDF, MJCF, SDF, GLB), edits and varies them, \
    proposes tasks in them, lets a simulated robot do these, and records demonstrations. Scenes, tasks and recordings are \
    known by the names that the calls give them. A scene is fit for use if its verdict is `pass`; see its image with \
    `inspect`. Lengths are meters, angles radians, masses kilograms; z points up.";

/// Arguments of `mcp`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Folder for scenes, tasks and recordings
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// TOML file laid over the defaults
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
}

/// Answers calls until standard input ends.
pub fn run(arguments: Arguments) -> Result<Exit, Failure> {
    let failed = |error: std::io::Error| {
        let message =
            format!("cannot use the folder {}: {error}; give --out another", arguments.out.display());
        Failure::new(Exit::Error, message)
    };
    let folder = Folder::open(&arguments.out).map_err(failed)?;
    let command = Command::new(arguments.config)
        .map_err(|error| Failure::new(Exit::Error, format!("cannot find this program: {error}")))?;
    block_on(async {
        let stopped =
            |error: &dyn std::fmt::Display| Failure::new(Exit::Error, format!("the protocol ended: {error}"));
        let tools = Tools { folder, command };
        let service = tools.serve(rmcp::transport::stdio()).await.map_err(|error| stopped(&error))?;
        service.waiting().await.map_err(|error| stopped(&error))?;
        Ok(Exit::Success)
    })
}

/// The tools, each a command of the program.
#[derive(Clone, Debug)]
struct Tools {
    folder: Folder,
    command: Command,
}

type Answer = Result<CallToolResult, ErrorData>;

#[tool_router]
impl Tools {
    /// Makes a scene from a description; takes some seconds. Answers with its certificate and an image.
    #[tool(annotations(title = "Make a scene", destructive_hint = false, open_world_hint = false))]
    async fn generate(
        &self,
        Parameters(given): Parameters<Generate>,
        context: RequestContext<RoleServer>,
    ) -> Answer {
        let Generate { scene, text, seed, max_objects } = given;
        let mut arguments = vec![option("--text", text), option("--out", self.folder.new_item(&scene)?)];
        arguments.extend(seed.map(|seed| option("--seed", seed)));
        arguments.extend(max_objects.map(|max_objects| option("--max-objects", max_objects)));
        let answer = self.command.run("generate", arguments, &context).await?;
        Ok(self.with_preview(answer, &scene))
    }

    /// Says what a description is understood as, without making a scene.
    #[tool(annotations(title = "Read a description", read_only_hint = true, open_world_hint = false))]
    async fn parse(
        &self,
        Parameters(given): Parameters<Parse>,
        context: RequestContext<RoleServer>,
    ) -> Answer {
        // Behind `--`, no text is an option.
        self.command.run("parse", vec!["--".to_owned(), given.text], &context).await
    }

    /// Makes a new scene from a finished one by an instruction in words.
    #[tool(annotations(title = "Edit a scene", destructive_hint = false, open_world_hint = false))]
    async fn edit(&self, Parameters(given): Parameters<Edit>, context: RequestContext<RoleServer>) -> Answer {
        let Edit { scene, text, new_scene, seed } = given;
        let mut arguments = self.within(&scene, &new_scene)?;
        arguments.push(option("--text", text));
        arguments.extend(seed.map(|seed| option("--seed", seed)));
        let answer = self.command.run("edit", arguments, &context).await?;
        Ok(self.with_preview(answer, &new_scene))
    }

    /// Makes scenes from a finished one that differ in layout, meshes, colors, light and more.
    #[tool(annotations(title = "Vary a scene", destructive_hint = false, open_world_hint = false))]
    async fn variants(
        &self,
        Parameters(given): Parameters<Variants>,
        context: RequestContext<RoleServer>,
    ) -> Answer {
        let Variants { scene, new_scenes, count, vary, seed } = given;
        let mut arguments = self.within(&scene, &new_scenes)?;
        arguments.push(option("--count", count));
        arguments.extend(vary.map(|axes| option("--vary", axes.join(","))));
        arguments.extend(seed.map(|seed| option("--seed", seed)));
        self.command.run("variants", arguments, &context).await
    }

    /// Shows a finished scene: its objects with poses, sizes and masses, and an image.
    #[tool(annotations(title = "Inspect a scene", read_only_hint = true, open_world_hint = false))]
    async fn inspect(&self, Parameters(given): Parameters<Inspect>) -> Answer {
        self.folder.item(&given.scene)?;
        let document = self.folder.document(&given.scene)?;
        let answer = CallToolResult::success(vec![ContentBlock::text(document)]);
        Ok(self.with_preview(answer, &given.scene))
    }

    /// Lists the scenes and other results that there are.
    #[tool(annotations(title = "List results", read_only_hint = true, open_world_hint = false))]
    async fn list(&self) -> Answer {
        Ok(CallToolResult::success(vec![ContentBlock::text(self.folder.list()?)]))
    }

    /// Proposes tasks for a robot in a finished scene, or reads one from an instruction.
    #[tool(annotations(title = "Propose tasks", read_only_hint = true, open_world_hint = false))]
    async fn tasks(
        &self,
        Parameters(given): Parameters<Tasks>,
        context: RequestContext<RoleServer>,
    ) -> Answer {
        let Tasks { scene, text, count, robot, rehearse } = given;
        let mut arguments = vec![option("--bundle", self.folder.item(&scene)?)];
        arguments.extend(text.map(|text| option("--text", text)));
        arguments.extend(count.map(|count| option("--count", count)));
        arguments.extend(robot.map(|robot| option("--robot", robot)));
        if !rehearse {
            arguments.push("--no-rehearse".to_owned());
        }
        self.command.run("tasks", arguments, &context).await
    }

    /// Lets a simulated robot do a task in a finished scene; the verdict says whether it is done.
    #[tool(annotations(title = "Do a task", destructive_hint = false, open_world_hint = false))]
    async fn execute(
        &self,
        Parameters(given): Parameters<Execute>,
        context: RequestContext<RoleServer>,
    ) -> Answer {
        let Execute { scene, task, robot, out, video, seed } = given;
        let mut arguments = self.within(&scene, &out)?;
        arguments.push(option("--task", instruction(task)?));
        arguments.extend(robot.map(|robot| option("--robot", robot)));
        arguments.extend(seed.map(|seed| option("--seed", seed)));
        if video {
            arguments.push("--video".to_owned());
        }
        self.command.run("execute", arguments, &context).await
    }

    /// Records demonstrations of a task as a LeRobot dataset; takes some seconds for each episode.
    #[tool(annotations(title = "Record demonstrations", destructive_hint = false, open_world_hint = false))]
    async fn episodes(
        &self,
        Parameters(given): Parameters<Episodes>,
        context: RequestContext<RoleServer>,
    ) -> Answer {
        let Episodes { scene, task, count, out, robot, seed } = given;
        let mut arguments = self.within(&scene, &out)?;
        arguments.push(option("--task", instruction(task)?));
        arguments.push(option("--count", count));
        arguments.extend(robot.map(|robot| option("--robot", robot)));
        arguments.extend(seed.map(|seed| option("--seed", seed)));
        self.command.run("episodes", arguments, &context).await
    }
}

impl Tools {
    /// Arguments of a command that reads a scene and writes a new folder.
    fn within(&self, scene: &str, out: &str) -> Result<Vec<String>, ErrorData> {
        Ok(vec![option("--bundle", self.folder.item(scene)?), option("--out", self.folder.new_item(out)?)])
    }

    /// The answer with the preview of a scene, if it has one.
    fn with_preview(&self, mut answer: CallToolResult, scene: &str) -> CallToolResult {
        answer.content.extend(self.folder.preview(scene));
        answer
    }
}

/// An instruction in words; of the name of a file the commands would read the task.
fn instruction(task: String) -> Result<String, ErrorData> {
    match execute::is_file(&task) {
        true => Err(ErrorData::invalid_params("task: give an instruction in words, not a file", None)),
        false => Ok(task),
    }
}

/// An option with its value in one argument, so that no value is an option of its own.
fn option(name: &str, value: impl std::fmt::Display) -> String {
    format!("{name}={value}")
}

#[tool_handler]
impl ServerHandler for Tools {
    fn get_info(&self) -> ServerConfig {
        let about = Implementation::new("tabletopgen", env!("CARGO_PKG_VERSION"));
        ServerConfig::new(ServerCapabilities::builder().enable_tools().build())
            .with_server_info(about)
            .with_instructions(INSTRUCTIONS)
    }
}

//! A command of this program as a process, whose JSON document is the answer of a tool.

use std::path::PathBuf;
use std::process::Stdio;

use rmcp::model::{CallToolResult, ContentBlock};
use rmcp::service::RequestContext;
use rmcp::{ErrorData, RoleServer};

/// The program that runs.
#[derive(Clone, Debug)]
pub struct Command {
    program: PathBuf,
    config: Option<PathBuf>,
}

impl Command {
    pub fn new(config: Option<PathBuf>) -> std::io::Result<Self> {
        Ok(Self { program: std::env::current_exe()?, config })
    }

    /// Runs a command and answers with what it prints: an error of the tool where it fails, so that an assistant reads
    /// why. A call that is cancelled ends it.
    ///
    /// # Errors
    ///
    /// An [`ErrorData`] if the process cannot be started.
    pub async fn run(
        &self,
        name: &str,
        arguments: Vec<String>,
        context: &RequestContext<RoleServer>,
    ) -> Result<CallToolResult, ErrorData> {
        let failed = |error: std::io::Error| {
            ErrorData::internal_error(format!("running `tabletopgen {name}`: {error}"), None)
        };
        let mut command = tokio::process::Command::new(&self.program);
        command.arg(name).arg("--json").arg("--quiet");
        if let Some(config) = &self.config {
            command.arg("--config").arg(config);
        }
        command.args(arguments).stdin(Stdio::null()).kill_on_drop(true);
        let output = tokio::select! {
            output = command.output() => output.map_err(failed)?,
            () = context.ct.cancelled() => {
                return Err(ErrorData::internal_error(format!("`tabletopgen {name}` was cancelled"), None));
            }
        };
        let document = String::from_utf8_lossy(&output.stdout).trim().to_owned();
        let complaints = String::from_utf8_lossy(&output.stderr).trim().to_owned();
        let texts = [document, complaints].into_iter().filter(|text| !text.is_empty());
        let content: Vec<ContentBlock> = texts.map(ContentBlock::text).collect();
        Ok(match output.status.success() {
            true => CallToolResult::success(content),
            false => CallToolResult::error(content),
        })
    }
}

//! Text of a USD layer: nested prims, properties and transforms.

use nalgebra::{Isometry3, Vector3};

use crate::export::numbers::{spaced, tuple, wxyz, xyz};

/// A layer under construction. Prims are closed in the order they were opened.
pub(super) struct Layer {
    text: String,
    depth: usize,
}

/// A number as text.
pub(super) fn real(value: f64) -> String {
    spaced(&[value])
}

impl Layer {
    /// Starts with the layer's metadata; `documentation` must not contain quotation marks.
    pub(super) fn new(default_prim: &str, documentation: &str) -> Self {
        let documentation = documentation.replace('"', "'");
        let text = format!(
            "#usda 1.0\n(\n    defaultPrim = \"{default_prim}\"\n    doc = \"{documentation}\"\n    \
             kilogramsPerUnit = 1\n    metersPerUnit = 1\n    upAxis = \"Z\"\n)\n"
        );
        Self { text, depth: 0 }
    }

    pub(super) fn open(&mut self, kind: &str, name: &str, schemas: &[&str]) {
        self.text.push('\n');
        self.line(&format!("def {kind} \"{name}\""));
        if !schemas.is_empty() {
            let quoted: Vec<String> = schemas.iter().map(|schema| format!("\"{schema}\"")).collect();
            self.line("(");
            self.line(&format!("    prepend apiSchemas = [{}]", quoted.join(", ")));
            self.line(")");
        }
        self.line("{");
        self.depth += 1;
    }

    pub(super) fn close(&mut self) {
        self.depth -= 1;
        self.line("}");
    }

    pub(super) fn line(&mut self, line: &str) {
        self.text.push_str(&"    ".repeat(self.depth));
        self.text.push_str(line);
        self.text.push('\n');
    }

    pub(super) fn pose(&mut self, pose: &Isometry3<f64>) {
        self.pose_and_scale(pose, None);
    }

    pub(super) fn pose_and_scale(&mut self, pose: &Isometry3<f64>, scale: Option<Vector3<f64>>) {
        self.line(&format!("double3 xformOp:translate = {}", tuple(&xyz(pose))));
        self.line(&format!("quatd xformOp:orient = {}", tuple(&wxyz(&pose.rotation))));
        let mut order = String::from("\"xformOp:translate\", \"xformOp:orient\"");
        if let Some(scale) = scale {
            self.line(&format!("double3 xformOp:scale = {}", tuple(scale.as_slice())));
            order.push_str(", \"xformOp:scale\"");
        }
        self.line(&format!("uniform token[] xformOpOrder = [{order}]"));
    }

    pub(super) fn finish(self) -> String {
        self.text
    }
}

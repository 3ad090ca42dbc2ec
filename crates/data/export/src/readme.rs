//! `README.md` of a bundle: its contents and how to load it in each simulator.

use scene::Scene;

use super::{Body, BundleFile, ExportSettings, UrdfPaths, UsdForm, ros_package, usd};

/// The text, with the scene's own names and paths in the examples.
pub fn write(scene: &Scene, bodies: &[Body], settings: &ExportSettings) -> BundleFile {
    let usd_form = settings.usd;
    let example = bodies.iter().find(|body| body.movable).or(bodies.first());
    let example = example.map_or("table", |body| &body.name);
    let rows: String = bodies
        .iter()
        .map(|body| {
            let mark = body.stand_in.as_ref().map_or_else(String::new, |mark| match mark.shown_as.as_str() {
                "" => " (stand-in)".to_owned(),
                shown_as => format!(" (stand-in, shown as: {})", cell(shown_as)),
            });
            format!("| `{}` | {}{mark} | {:.3} |\n", body.name, cell(&body.label), body.mass.mass_kg)
        })
        .collect();
    let stand_ins = if bodies.iter().any(|body| body.stand_in.is_some()) { STAND_INS } else { "" };
    let text = TEMPLATE
        .replace("{id}", &scene.id)
        .replace("{example}", example)
        .replace("{height}", &format!("{:.3}", scene.table.height_m))
        .replace("{usd_stage}", usd::stage_path(usd_form))
        .replace("{validated_prop}", &validated_prop(usd_form, example))
        .replace("{usd_prop}", &usd::prop_path(usd_form, "<name>"))
        .replace("{stand_ins}", stand_ins)
        .replace("{ros}", &ros(scene, settings.urdf))
        .replace("{grasps}", &grasps(scene))
        .replace("{rows}", &rows);
    BundleFile::text("README.md", text, "readme", "text/markdown")
}

/// The section of a bundle whose URDF folder is a ROS 2 package.
fn ros(scene: &Scene, paths: UrdfPaths) -> String {
    match paths {
        UrdfPaths::Relative => String::new(),
        UrdfPaths::Ros2 => ROS.replace("{package}", &ros_package::name(scene)),
    }
}

/// Instructions for validating a prop; the validator opens no packages.
fn validated_prop(form: UsdForm, name: &str) -> String {
    match form {
        UsdForm::Usdz => String::new(),
        UsdForm::Usda | UsdForm::Usdc => VALIDATED_PROP.replace("{path}", &usd::prop_path(form, name)),
    }
}

/// The section of a bundle with grasps.
fn grasps(scene: &Scene) -> String {
    let tried = scene.instances.iter().find_map(|instance| instance.grasps.as_ref());
    tried.map_or_else(String::new, |file| {
        GRASPS.replace("{robot}", &cell(&file.robot)).replace("{frame}", &file.gripper_frame)
    })
}

/// A label escaped for a cell of a Markdown table.
fn cell(label: &str) -> String {
    let mut text = String::new();
    for c in label.chars() {
        match c {
            '\n' | '\r' | '\t' => text.push(' '),
            '<' => text.push_str("&lt;"),
            '>' => text.push_str("&gt;"),
            '&' => text.push_str("&amp;"),
            '|' | '`' | '*' | '_' | '[' | ']' | '\\' | '{' | '}' | '#' | '!' => {
                text.push('\\');
                text.push(c);
            }
            c if c.is_control() => text.push('\u{fffd}'),
            c => text.push(c),
        }
    }
    text
}

/// The paragraph of a bundle with stand-ins.
const STAND_INS: &str = "
A stand-in is another body, or a plain shape, for an object that the catalog does not have; the label keeps the words for the
object. Every format marks it by `stand_in`, with the noun that was asked for (`stands_for`) and what stands there
(`shown_as`): in `scene.json`, among the extras of glTF nodes and in `tabletopgen:label` elements of URDF, as attributes of
USD prims and of SDF models (`tabletopgen:stand_in`), and as texts in MJCF (`stand_in_<name>`).
";

/// Section about the grasps of the request's robot.
const GRASPS: &str = r#"
## Grasps

`grasps` of an object in `scene.json` lists how `{robot}` takes it, the best first: the hand closed, lifted, shook and held the
object in simulation. Poses place the frame `{frame}` (z away from the arm, fingers close along y) in the object's frame.
`grasps/<name>.yaml` has the same in the format `isaac_grasp`; objects without a stable grasp have no file. Grasps are of the
object alone on a plane; `robot` in `report.json` counts the objects that can be picked up where they are.

```python
import json
scene = json.load(open("scene.json", encoding="utf-8"))
for o in scene["instances"]:
    for grasp in o.get("grasps", {}).get("grasps", [])[:1]:
        print(o["name"], grasp["object_from_tool"], grasp["opening_m"], grasp["force_n"])
```
"#;

/// Section about the use of the ROS 2 package.
const ROS: &str = "
## ROS 2

`urdf/` is the package `{package}`; its meshes are `package://` paths, which the examples above do not resolve.

```sh
mkdir -p ~/scene_ws/src && cp -r urdf ~/scene_ws/src/{package} && cd ~/scene_ws
colcon build && . install/setup.sh
ros2 launch urdf_tutorial display.launch.py model:=$(ros2 pkg prefix {package})/share/{package}/scene.urdf
```
";

const VALIDATED_PROP: &str = "Whether a prop is a SimReady Robotics-Prop (the stage is none):

```sh
pip install simready-validate simready-foundation-tier-core
simready-validate --profile Robotics-Prop --version 4.0.0 {path}
```

";

const TEMPLATE: &str = include_str!("readme_template.md");

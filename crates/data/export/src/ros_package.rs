//! The folder `urdf/` as a ROS 2 package of the build type `ament_cmake`: `package.xml` and `CMakeLists.txt` that
//! install the descriptions and meshes, so that RViz and MoveIt resolve `package://` paths.

use scene::Scene;

use super::{Body, BundleFile, ExportSettings};
use markup::xml::XmlDocument;

/// Name of the package of a scene.
pub fn name(scene: &Scene) -> String {
    format!("scene_{}", scene.id)
}

/// The package's own files.
pub fn files(scene: &Scene, bodies: &[Body], settings: &ExportSettings) -> [BundleFile; 2] {
    let name = name(scene);
    let folders: String = bodies.iter().map(|body| format!(" {}", body.name)).collect();
    let build = format!(
        "cmake_minimum_required(VERSION 3.8)\nproject({name} NONE)\nfind_package(ament_cmake REQUIRED)\n\
         install(DIRECTORY{folders} DESTINATION share/${{PROJECT_NAME}})\n\
         install(FILES scene.urdf DESTINATION share/${{PROJECT_NAME}})\nament_package()\n"
    );
    [
        BundleFile::text("urdf/package.xml", manifest(&name, settings), "urdf_package", "application/xml"),
        BundleFile::text("urdf/CMakeLists.txt", build, "urdf_package", "text/plain"),
    ]
}

fn manifest(name: &str, settings: &ExportSettings) -> String {
    let mut document = XmlDocument::new();
    document.open("package", &[("format", "3")]);
    document.text_element("name", name);
    document.text_element("version", "1.0.0");
    document.text_element("description", "A tabletop scene.");
    document.text_element_with("maintainer", &[("email", "nobody@example.invalid")], &settings.author);
    document.text_element("license", &settings.licence);
    document.text_element("buildtool_depend", "ament_cmake");
    document.open("export", &[]);
    document.text_element("build_type", "ament_cmake");
    document.finish()
}

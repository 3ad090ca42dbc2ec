//! Materials of a prop: UsdPreviewSurface for the eye, PhysicsMaterialAPI for contact.

use crate::export::Body;
use crate::export::number::push_f32;
use crate::geometry::Material;

use super::layer::{Layer, push_tuple_f32, quoted, tuple};

/// Name of the material that holds friction. Its capital letter cannot occur in a visual material's.
pub const PHYSICS_MATERIAL: &str = "Physics_material";

/// Where a textured material's picture lies, relative to the prop's layer.
pub fn texture_path(body: &str, material: &Material) -> String {
    format!("textures/{body}_{}.png", material.name)
}

/// The scope `Looks` below `/<body>`.
pub fn write_looks(layer: &mut Layer, body: &Body) {
    layer.prim("Scope", "Looks", &[], |layer| {
        for material in &body.visual.materials {
            write_surface(layer, body, material);
        }
        write_contact(layer, body);
    });
}

fn write_surface(layer: &mut Layer, body: &Body, material: &Material) {
    let path = format!("/{}/Looks/{}", body.name, material.name);
    let metadata = ["prepend apiSchemas = [\"SemanticsLabelsAPI:material\"]"];
    layer.prim("Material", &material.name, &metadata, |layer| {
        layer.line(&format!("token[] semantics:labels:material = [{}]", quoted(&material.name)));
        layer.line(&format!("token outputs:surface.connect = <{path}/preview.outputs:surface>"));
        layer.prim("Shader", "preview", &[], |layer| {
            layer.line("uniform token info:id = \"UsdPreviewSurface\"");
            if material.base_color_texture.is_some() {
                layer.line(&format!("color3f inputs:diffuseColor.connect = <{path}/base_color.outputs:rgb>"));
            } else {
                layer.line(&format!("color3f inputs:diffuseColor = {}", linear_color(material)));
            }
            for (input, value) in [
                ("metallic", material.metalness),
                ("opacity", material.opacity),
                ("roughness", material.roughness),
            ] {
                let mut line = format!("float inputs:{input} = ");
                push_f32(&mut line, value.clamp(0.0, 1.0));
                layer.line(&line);
            }
            layer.line("token outputs:surface");
        });
        if material.base_color_texture.is_some() {
            let [r, g, b] = material.base_color.to_linear();
            layer.prim("Shader", "base_color", &[], |layer| {
                layer.line("uniform token info:id = \"UsdUVTexture\"");
                layer.line(&format!("asset inputs:file = @./{}@", texture_path(&body.name, material)));
                let mut line = "float4 inputs:scale = ".to_owned();
                push_tuple_f32(&mut line, &[r, g, b, 1.0]);
                layer.line(&line);
                layer.line("token inputs:sourceColorSpace = \"sRGB\"");
                layer.line(&format!("float2 inputs:st.connect = <{path}/st.outputs:result>"));
                layer.line("token inputs:wrapS = \"repeat\"");
                layer.line("token inputs:wrapT = \"repeat\"");
                layer.line("float3 outputs:rgb");
            });
            layer.prim("Shader", "st", &[], |layer| {
                layer.line("uniform token info:id = \"UsdPrimvarReader_float2\"");
                layer.line("string inputs:varname = \"st\"");
                layer.line("float2 outputs:result");
            });
        }
    });
}

fn write_contact(layer: &mut Layer, body: &Body) {
    let metadata = ["prepend apiSchemas = [\"PhysicsMaterialAPI\", \"SemanticsLabelsAPI:material\"]"];
    let friction = body.friction;
    layer.prim("Material", PHYSICS_MATERIAL, &metadata, |layer| {
        for (attribute, value) in [
            ("float physics:dynamicFriction", friction.dynamic_coefficient),
            ("float physics:restitution", body.restitution),
            ("float physics:staticFriction", friction.static_coefficient),
            // Engines that know rolling and spinning resistance read it under their own names.
            ("custom float newton:rollingFriction", body.rolling_friction_m),
            ("custom float newton:torsionalFriction", body.torsional_friction_m),
            ("custom float mjc:rollingfriction", body.rolling_friction_m),
            ("custom float mjc:torsionalfriction", body.torsional_friction_m),
        ] {
            let mut line = format!("{attribute} = ");
            push_f32(&mut line, value as f32);
            layer.line(&line);
        }
        let semantic = body.visual.materials.first().map_or("unknown", |material| material.name.as_str());
        layer.line(&format!("token[] semantics:labels:material = [{}]", quoted(semantic)));
    });
}

fn linear_color(material: &Material) -> String {
    tuple(&material.base_color.to_linear().map(|c| f64::from((c * 1e6).round()) / 1e6))
}

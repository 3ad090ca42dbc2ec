//! Materials of a prop: UsdPreviewSurface for rendering, PhysicsMaterialAPI for contact.

use crate::Body;
use geometry::{Material, Rgb};

use super::layer::{Path, Prim};
use super::nonvisual_material;
use super::prim_names::{MATERIALS, PHYSICS_MATERIAL};
use super::value::{Value, ValueType};

/// Path of a material's texture, relative to the prop's layer.
pub fn texture_path(body: &str, material: &Material) -> String {
    format!("textures/{body}_{}.png", material.name)
}

/// Path of a material's map of normals, relative to the prop's layer.
pub fn normals_path(body: &str, material: &Material) -> String {
    format!("textures/{body}_{}_normals.png", material.name)
}

/// The scope of a body's materials.
pub fn materials(body: &Body) -> Prim {
    let mut scope = Prim::new("Scope", MATERIALS);
    for material in &body.visual.materials {
        scope.add(surface(body, material));
    }
    scope.add(contact(body));
    scope
}

fn surface(body: &Body, material: &Material) -> Prim {
    let output = |shader: &str, name: &str| {
        Path::prim(&[&body.name, MATERIALS, &material.name, shader]).property(&format!("outputs:{name}"))
    };
    let mut prim = Prim::new("Material", &material.name).with_schemas(&["SemanticsLabelsAPI:material"]);
    prim.set("semantics:labels:material", Value::tokens(&[&material.name]));
    nonvisual_material::write(&mut prim, &body.substance, material);
    prim.connect("outputs:surface", ValueType::Token, output("preview", "surface"));
    let mut preview = Prim::new("Shader", "preview");
    preview.set_uniform("info:id", Value::token("UsdPreviewSurface"));
    if material.base_color_texture.is_some() {
        preview.connect("inputs:diffuseColor", ValueType::Color3f, output("base_color", "rgb"));
    } else {
        preview.set("inputs:diffuseColor", Value::Color3f(linear_color(material)));
    }
    preview.set("inputs:metallic", Value::Float(material.metalness.clamp(0.0, 1.0)));
    if material.relief > 0.0 && material.base_color_texture.is_some() {
        preview.connect("inputs:normal", ValueType::Normal3f, output("normals", "rgb"));
    }
    preview.set("inputs:opacity", Value::Float(material.opacity.clamp(0.0, 1.0)));
    preview.set("inputs:roughness", Value::Float(material.roughness.clamp(0.0, 1.0)));
    preview.declare("outputs:surface", ValueType::Token);
    prim.add(preview);
    if material.base_color_texture.is_some() {
        let [r, g, b] = material.base_color.to_linear();
        let mut image = Prim::new("Shader", "base_color");
        image.set_uniform("info:id", Value::token("UsdUVTexture"));
        let path = format!("./{}", texture_path(&body.name, material));
        image.set("inputs:file", Value::asset(&path));
        image.set("inputs:scale", Value::Float4([r, g, b, 1.0]));
        image.set("inputs:sourceColorSpace", Value::token("sRGB"));
        image.connect("inputs:st", ValueType::Float2, output("st", "result"));
        image.set("inputs:wrapS", Value::token("repeat"));
        image.set("inputs:wrapT", Value::token("repeat"));
        image.declare("outputs:rgb", ValueType::Float3);
        prim.add(image);
        if material.relief > 0.0 {
            prim.add(normals(body, material, output("st", "result")));
        }
        let mut st = Prim::new("Shader", "st");
        st.set_uniform("info:id", Value::token("UsdPrimvarReader_float2"));
        st.set("inputs:varname", Value::string("st"));
        st.declare("outputs:result", ValueType::Float2);
        prim.add(st);
    }
    prim
}

/// The shader that reads the map of normals: bytes become components in -1..1.
fn normals(body: &Body, material: &Material, st: Path) -> Prim {
    let mut image = Prim::new("Shader", "normals");
    image.set_uniform("info:id", Value::token("UsdUVTexture"));
    image.set("inputs:bias", Value::Float4([-1.0, -1.0, -1.0, 0.0]));
    image.set("inputs:file", Value::asset(&format!("./{}", normals_path(&body.name, material))));
    image.set("inputs:scale", Value::Float4([2.0, 2.0, 2.0, 1.0]));
    image.set("inputs:sourceColorSpace", Value::token("raw"));
    image.connect("inputs:st", ValueType::Float2, st);
    image.set("inputs:wrapS", Value::token("repeat"));
    image.set("inputs:wrapT", Value::token("repeat"));
    image.declare("outputs:rgb", ValueType::Float3);
    image
}

fn contact(body: &Body) -> Prim {
    let schemas = ["PhysicsMaterialAPI", "SemanticsLabelsAPI:material"];
    let mut prim = Prim::new("Material", PHYSICS_MATERIAL).with_schemas(&schemas);
    let number = |value: f64| Value::Float(value as f32);
    prim.set("physics:dynamicFriction", number(body.friction.dynamic_coefficient));
    prim.set("physics:restitution", number(body.restitution));
    prim.set("physics:staticFriction", number(body.friction.static_coefficient));
    let semantic = body.visual.materials.first().map_or("unknown", |material| material.name.as_str());
    prim.set("semantics:labels:material", Value::tokens(&[semantic]));
    prim
}

fn linear_color(material: &Material) -> [f32; 3] {
    material.base_color.to_linear().map(six_decimals)
}

/// The color of a material for viewers without material support: base color times mean texture color, linear.
pub fn display_color(material: &Material) -> [f32; 3] {
    let tint = material.base_color.to_linear();
    let mean = match &material.base_color_texture {
        Some(texture) => {
            // The last level of the mipmap is one texel, the mean.
            let [r, g, b, _] = texture.halved().last().unwrap_or(texture).pixel(0, 0);
            Rgb([r, g, b].map(|byte| f32::from(byte) / 255.0)).to_linear()
        }
        None => [1.0; 3],
    };
    [0, 1, 2].map(|k| six_decimals(tint[k] * mean[k]).clamp(0.0, 1.0))
}

fn six_decimals(value: f32) -> f32 {
    (f64::from((value * 1e6).round()) / 1e6) as f32
}

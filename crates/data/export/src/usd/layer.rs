//! A USD layer as a value, restricted to the features that layers of a bundle use.
//!
//! Built once, then written as text ([`super::text_file`]) or in the crate format ([`super::crate_file`]).
//! The type of an attribute follows from its value, and the default prim is the single root. A name used twice in one
//! scope is a bug and panics.

use std::fmt;

use super::value::{Dictionary, Text, Value, ValueType};

/// The content of one file: z up, meters, kilograms; the root is the default prim.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// `customLayerData`.
    pub custom_data: Dictionary,
    pub root: Prim,
}

/// `def <type> "<name>"` or `over "<name>"`.
#[derive(Clone, Debug, PartialEq)]
pub struct Prim {
    pub specifier: Specifier,
    /// An identifier.
    pub name: String,
    /// Prepended `apiSchemas`.
    pub schemas: Vec<&'static str>,
    /// `assetInfo`; absent when empty.
    pub asset_info: Dictionary,
    pub display_name: Option<Text>,
    pub kind: Option<&'static str>,
    /// The referenced layer (prepended), relative to this one.
    pub reference: Option<Text>,
    /// Variant sets, each named once.
    pub variant_sets: Vec<VariantSet>,
    properties: Vec<Property>,
    children: Vec<Prim>,
}

/// Specifier of a prim.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Specifier {
    /// Defines a prim of that type.
    Def(&'static str),
    /// Overrides a prim that another layer defines.
    Over,
}

/// A variant set of two variants: `Disabled` (selected, empty) and `Enabled`, which loads a layer as payload.
#[derive(Clone, Debug, PartialEq)]
pub struct VariantSet {
    /// Name of the variant set; an identifier.
    pub name: &'static str,
    /// The layer that `Enabled` loads, relative to this one.
    pub payload: Text,
}

impl VariantSet {
    pub const DISABLED: &'static str = "Disabled";
    pub const ENABLED: &'static str = "Enabled";
}

/// An attribute or a relationship.
#[derive(Clone, Debug, PartialEq)]
pub struct Property {
    /// Identifiers with colons between them.
    pub name: String,
    pub content: Content,
}

/// Content of a property.
#[derive(Clone, Debug, PartialEq)]
pub enum Content {
    Attribute {
        value: Value,
        variability: Variability,
        interpolation: Option<Interpolation>,
        /// Whether no schema declares it.
        custom: bool,
    },
    /// An attribute without a value.
    Declaration(ValueType),
    /// An attribute that is connected to another one.
    Connection(ValueType, Path),
    /// A relationship with one target.
    Relationship(Path),
}

/// Dependence of an attribute on time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variability {
    Varying,
    Uniform,
}

/// Interpolation of a primvar array over a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// One element per face.
    Uniform,
    /// One element per corner of a face.
    FaceVarying,
    /// One element for the whole mesh.
    Constant,
}

impl Interpolation {
    pub fn token(self) -> &'static str {
        match self {
            Interpolation::Uniform => "uniform",
            Interpolation::FaceVarying => "faceVarying",
            Interpolation::Constant => "constant",
        }
    }
}

/// Absolute path of a prim or a property.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Path {
    prims: Vec<String>,
    property: Option<String>,
}

impl Path {
    /// The path of a prim, by names from the root.
    pub fn prim(names: &[&str]) -> Self {
        Self { prims: names.iter().map(|name| (*name).to_owned()).collect(), property: None }
    }

    /// A property of this prim.
    pub fn property(self, name: &str) -> Self {
        Self { property: Some(name.to_owned()), ..self }
    }

    /// Names from the root prim down.
    pub fn prim_names(&self) -> &[String] {
        &self.prims
    }

    pub fn property_name(&self) -> Option<&str> {
        self.property.as_deref()
    }
}

impl fmt::Display for Path {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.prims.iter().try_for_each(|name| write!(f, "/{name}"))?;
        self.property.iter().try_for_each(|name| write!(f, ".{name}"))
    }
}

impl Prim {
    /// An empty prim. The name must be an identifier.
    pub fn new(type_name: &'static str, name: &str) -> Self {
        Self::specified(Specifier::Def(type_name), name)
    }

    /// An override of a prim of another layer. The name must be an identifier.
    pub fn over(name: &str) -> Self {
        Self::specified(Specifier::Over, name)
    }

    fn specified(specifier: Specifier, name: &str) -> Self {
        Self {
            specifier,
            name: name.to_owned(),
            schemas: Vec::new(),
            asset_info: Dictionary::default(),
            display_name: None,
            kind: None,
            reference: None,
            variant_sets: Vec::new(),
            properties: Vec::new(),
            children: Vec::new(),
        }
    }

    /// With API schemas applied.
    pub fn with_schemas(self, schemas: &[&'static str]) -> Self {
        Self { schemas: schemas.to_vec(), ..self }
    }

    /// Sets an attribute of the prim's schemas.
    pub fn set(&mut self, name: &str, value: Value) {
        self.push(name, attribute(value, Variability::Varying));
    }

    /// As [`Prim::set`], for an attribute with uniform variability.
    pub fn set_uniform(&mut self, name: &str, value: Value) {
        self.push(name, attribute(value, Variability::Uniform));
    }

    /// As [`Prim::set_uniform`], for an attribute that no schema declares.
    pub fn set_custom(&mut self, name: &str, value: Value) {
        let variability = Variability::Uniform;
        self.push(name, Content::Attribute { value, variability, interpolation: None, custom: true });
    }

    /// As [`Prim::set`], for an array with interpolation metadata.
    pub fn set_interpolated(&mut self, name: &str, value: Value, interpolation: Interpolation) {
        let (variability, interpolation) = (Variability::Varying, Some(interpolation));
        self.push(name, Content::Attribute { value, variability, interpolation, custom: false });
    }

    /// Declares an attribute without a value.
    pub fn declare(&mut self, name: &str, value_type: ValueType) {
        self.push(name, Content::Declaration(value_type));
    }

    /// Connects an attribute to another one.
    pub fn connect(&mut self, name: &str, value_type: ValueType, source: Path) {
        self.push(name, Content::Connection(value_type, source));
    }

    /// Writes a relationship with one target.
    pub fn relate(&mut self, name: &str, target: Path) {
        self.push(name, Content::Relationship(target));
    }

    fn push(&mut self, name: &str, content: Content) {
        let known = self.properties.iter().any(|property| property.name == name);
        assert!(!known, "{name} is twice in the prim {}", self.name);
        self.properties.push(Property { name: name.to_owned(), content });
    }

    /// Adds a prim below this one.
    pub fn add(&mut self, child: Prim) {
        let known = self.children.iter().any(|known| known.name == child.name);
        assert!(!known, "{} is twice below the prim {}", child.name, self.name);
        self.children.push(child);
    }

    pub fn properties(&self) -> &[Property] {
        &self.properties
    }

    pub fn children(&self) -> &[Prim] {
        &self.children
    }
}

/// An attribute of a schema, without interpolation.
fn attribute(value: Value, variability: Variability) -> Content {
    Content::Attribute { value, variability, interpolation: None, custom: false }
}

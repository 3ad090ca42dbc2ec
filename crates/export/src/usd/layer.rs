//! A USD layer as a value: what layers of a bundle contain, and nothing else.
//!
//! Built once, then written as text ([`super::text_file`]) or in the crate format ([`super::crate_file`]).
//! The type of an attribute follows from its value and the default prim is the one root, so neither can be
//! wrong; a name used twice in one place is a mistake of the program and panics.

use std::fmt;

use super::value::{Dictionary, Text, Value, ValueType};

/// A file's worth of prims: z up, meters, kilograms, with the root as its default prim.
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
    /// The layer that is referenced (prepended), relative to this one.
    pub reference: Option<Text>,
    /// Variant sets, each named once.
    pub switches: Vec<Switch>,
    properties: Vec<Property>,
    children: Vec<Prim>,
}

/// What a prim in a layer is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Specifier {
    /// Makes a prim of that type.
    Def(&'static str),
    /// Says more about a prim that another layer makes.
    Over,
}

/// A variant set of two: `Disabled`, which is selected and says nothing, and `Enabled`, which loads a layer.
#[derive(Clone, Debug, PartialEq)]
pub struct Switch {
    /// Of the variant set; an identifier.
    pub name: &'static str,
    /// The layer that `Enabled` loads, relative to this one.
    pub payload: Text,
}

impl Switch {
    pub const OFF: &'static str = "Disabled";
    pub const ON: &'static str = "Enabled";
}

/// An attribute or a relationship.
#[derive(Clone, Debug, PartialEq)]
pub struct Property {
    /// Identifiers with colons between them.
    pub name: String,
    pub content: Content,
}

/// What a property says.
#[derive(Clone, Debug, PartialEq)]
pub enum Content {
    Attribute {
        value: Value,
        variability: Variability,
        interpolation: Option<Interpolation>,
    },
    /// An attribute without a value.
    Declaration(ValueType),
    /// An attribute that has its value from elsewhere.
    Connection(ValueType, Path),
    /// A relationship with one target.
    Relationship(Path),
}

/// Whether an attribute may change over time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variability {
    Varying,
    Uniform,
}

/// How the elements of an array belong to a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// One a face.
    Uniform,
    /// One a corner of a face.
    FaceVarying,
    /// One for all.
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

/// A prim, or a property of it, seen from the root of the layer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Path {
    prims: Vec<String>,
    property: Option<String>,
}

impl Path {
    /// The prim that these names lead to.
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
    /// Without anything in it. The name must be an identifier.
    pub fn new(type_name: &'static str, name: &str) -> Self {
        Self::specified(Specifier::Def(type_name), name)
    }

    /// More about a prim of another layer. The name must be an identifier.
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
            switches: Vec::new(),
            properties: Vec::new(),
            children: Vec::new(),
        }
    }

    /// With API schemas applied.
    pub fn with_schemas(self, schemas: &[&'static str]) -> Self {
        Self { schemas: schemas.to_vec(), ..self }
    }

    /// Writes an attribute of the prim's schemas.
    pub fn set(&mut self, name: &str, value: Value) {
        let content = Content::Attribute { value, variability: Variability::Varying, interpolation: None };
        self.push(name, content);
    }

    /// As [`Prim::set`], for an attribute that cannot change over time.
    pub fn set_uniform(&mut self, name: &str, value: Value) {
        let content = Content::Attribute { value, variability: Variability::Uniform, interpolation: None };
        self.push(name, content);
    }

    /// As [`Prim::set`], for an array that says how its elements belong to the mesh.
    pub fn set_interpolated(&mut self, name: &str, value: Value, interpolation: Interpolation) {
        let interpolation = Some(interpolation);
        self.push(name, Content::Attribute { value, variability: Variability::Varying, interpolation });
    }

    /// Declares an attribute without a value.
    pub fn declare(&mut self, name: &str, value_type: ValueType) {
        self.push(name, Content::Declaration(value_type));
    }

    /// Lets an attribute have its value from another.
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

//! Typed values, texts and dictionaries of a layer.

/// Declares [`Value`] and its [`ValueType`] from one table: variant, Rust type, name of the type in USD.
macro_rules! value_types {
    ($($variant:ident($holds:ty) $name:literal,)*) => {
        /// A value of one of the types used in layers of a bundle. Numbers are finite.
        #[derive(Clone, Debug, PartialEq)]
        #[cfg_attr(not(test), expect(dead_code, reason = "normals of a texture are connected and have no value"))]
        pub enum Value {
            $($variant($holds),)*
        }

        /// The type of a [`Value`].
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum ValueType {
            $($variant,)*
        }

        impl Value {
            pub fn value_type(&self) -> ValueType {
                match self {
                    $(Value::$variant(_) => ValueType::$variant,)*
                }
            }
        }

        impl ValueType {
            /// Name of the type in USD, including its role.
            pub fn name(self) -> &'static str {
                match self {
                    $(ValueType::$variant => $name,)*
                }
            }
        }
    };
}

value_types! {
    Bool(bool) "bool",
    Int(i32) "int",
    Float(f32) "float",
    Double(f64) "double",
    String(Text) "string",
    Token(Text) "token",
    Asset(Text) "asset",
    Float2([f32; 2]) "float2",
    Float3([f32; 3]) "float3",
    Float4([f32; 4]) "float4",
    Double3([f64; 3]) "double3",
    Point3f([f32; 3]) "point3f",
    Vector3f([f32; 3]) "vector3f",
    Color3f([f32; 3]) "color3f",
    Normal3f([f32; 3]) "normal3f",
    Quatf(Quaternion<f32>) "quatf",
    Quatd(Quaternion<f64>) "quatd",
    Ints(Vec<i32>) "int[]",
    Floats(Vec<f32>) "float[]",
    Tokens(Vec<Text>) "token[]",
    Float3s(Vec<[f32; 3]>) "float3[]",
    Point3fs(Vec<[f32; 3]>) "point3f[]",
    Normal3fs(Vec<[f32; 3]>) "normal3f[]",
    Color3fs(Vec<[f32; 3]>) "color3f[]",
    TexCoord2fs(Vec<[f32; 2]>) "texCoord2f[]",
}

impl Value {
    pub fn string(text: &str) -> Self {
        Value::String(text.into())
    }

    pub fn token(text: &str) -> Self {
        Value::Token(text.into())
    }

    /// An array of at least one token.
    pub fn tokens(texts: &[&str]) -> Self {
        Value::Tokens(texts.iter().map(|text| Text::from(*text)).collect())
    }

    /// A path relative to the layer, without `@` in it.
    pub fn asset(path: &str) -> Self {
        Value::Asset(path.into())
    }
}

/// A quaternion with named components, because the component order differs between file formats.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quaternion<T> {
    pub w: T,
    pub xyz: [T; 3],
}

impl Quaternion<f64> {
    pub fn in_f32(self) -> Quaternion<f32> {
        Quaternion { w: self.w as f32, xyz: self.xyz.map(|value| value as f32) }
    }
}

impl From<glam::DQuat> for Quaternion<f64> {
    fn from(q: glam::DQuat) -> Self {
        Self { w: q.w, xyz: [q.x, q.y, q.z] }
    }
}

/// Text without NUL, which terminates strings in many readers. A NUL becomes U+FFFD.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Text(String);

impl From<&str> for Text {
    fn from(text: &str) -> Self {
        Self(text.replace('\0', "\u{fffd}"))
    }
}

impl std::ops::Deref for Text {
    type Target = str;

    fn deref(&self) -> &str {
        &self.0
    }
}

/// Unique names with their entries.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Dictionary(Vec<(String, Entry)>);

/// An entry of a dictionary: a value or a nested dictionary.
#[derive(Clone, Debug, PartialEq)]
pub enum Entry {
    Value(Value),
    Dictionary(Dictionary),
}

impl Dictionary {
    /// Adds a value. `name` must be an identifier that the dictionary does not contain yet.
    pub fn with(self, name: &str, value: Value) -> Self {
        self.with_entry(name, Entry::Value(value))
    }

    /// Adds a nested dictionary; `name` as in [`Dictionary::with`].
    pub fn with_dictionary(self, name: &str, inner: Dictionary) -> Self {
        self.with_entry(name, Entry::Dictionary(inner))
    }

    fn with_entry(mut self, name: &str, entry: Entry) -> Self {
        assert!(self.0.iter().all(|(known, _)| known != name), "{name} is twice in one dictionary");
        self.0.push((name.to_owned(), entry));
        self
    }

    pub fn entries(&self) -> &[(String, Entry)] {
        &self.0
    }
}

//! Reads a ZIP archive of an OBJ file with MTL files and images into one mesh, z up. Some mesh generators deliver this
//! format.
//!
//! Entries are read in order and identified by the last component of their names. Nothing is written to disk, and no
//! name is resolved as a path. Sizes are bounded while unpacking ([`Limits`]), whatever the archive declares. Materials
//! keep their color (`Kd`) and texture (`map_Kd`). Hostile bytes give an error and never a panic.

use std::collections::{BTreeMap, HashMap};
use std::io::{Cursor, Read};
use std::str::SplitAsciiWhitespace;

use glam::{DVec3, Vec2, Vec3};

use geometry::{FaceGroup, Material, Rgb, TexturedMesh};
use imaging::Texture;
use imaging::codec::{CodecError, decode_image};

/// Bounds on the allocations that an archive can cause.
struct Limits;

impl Limits {
    const ENTRIES: usize = 256;
    const OBJ_BYTES: u64 = 512 << 20;
    const OTHER_BYTES: u64 = 64 << 20;
    const ALL_BYTES: u64 = 768 << 20;
    const VERTICES: usize = 8_000_000;
    const TRIANGLES: usize = 8_000_000;
    const MATERIALS: usize = 256;
    const PIXELS: u64 = 128 << 20;
}

/// Reason why bytes were not read as a mesh.
#[derive(Debug, thiserror::Error)]
pub enum ObjArchiveError {
    #[error("not a ZIP archive that can be read: {0}")]
    NotZip(#[from] zip::result::ZipError),
    #[error("an entry of the archive is broken: {0}")]
    Entry(#[from] std::io::Error),
    #[error("the archive holds no OBJ file")]
    NoObj,
    #[error("the archive is larger than accepted ({0}); reduce it")]
    TooLarge(&'static str),
    #[error("line {line} of the OBJ file cannot be read: {what}")]
    Line { line: usize, what: &'static str },
    #[error("a texture of the archive could not be read")]
    Texture(#[from] CodecError),
}

/// Whether the bytes begin with the signature of a ZIP archive.
pub fn is_archive(bytes: &[u8]) -> bool {
    bytes.starts_with(b"PK\x03\x04")
}

/// All triangles of the archive's first OBJ file, rotated from y up to z up. Materials are named by their number.
///
/// # Errors
///
/// [`ObjArchiveError`] for damaged or oversized archives and for invalid lines.
pub fn read_mesh_obj_archive(bytes: &[u8]) -> Result<TexturedMesh, ObjArchiveError> {
    let mut entries = Entries::of(bytes)?;
    let obj = entries.first_obj.take().ok_or(ObjArchiveError::NoObj)?;
    let materials = read_materials(&entries)?;
    Reader::new(&materials).read(&String::from_utf8_lossy(&obj))
}

/// Entries of the archive that matter, by the last component of each name in lower case.
struct Entries {
    first_obj: Option<Vec<u8>>,
    libraries: Vec<Vec<u8>>,
    images: BTreeMap<String, Vec<u8>>,
}

impl Entries {
    fn of(bytes: &[u8]) -> Result<Self, ObjArchiveError> {
        let mut archive = zip::ZipArchive::new(Cursor::new(bytes))?;
        if archive.len() > Limits::ENTRIES {
            return Err(ObjArchiveError::TooLarge("more than 256 entries"));
        }
        let mut entries = Self { first_obj: None, libraries: Vec::new(), images: BTreeMap::new() };
        let mut left = Limits::ALL_BYTES;
        for index in 0..archive.len() {
            let file = archive.by_index(index)?;
            let name = last_part(&file.name()?);
            let kind = name.rsplit('.').next().unwrap_or_default().to_owned();
            let limit = match kind.as_str() {
                "obj" if entries.first_obj.is_none() => Limits::OBJ_BYTES,
                "mtl" | "png" | "jpg" | "jpeg" | "webp" => Limits::OTHER_BYTES,
                _ => continue,
            };
            let unpacked = bounded(file, limit.min(left))?;
            left -= unpacked.len() as u64;
            match kind.as_str() {
                "obj" => entries.first_obj = Some(unpacked),
                "mtl" => entries.libraries.push(unpacked),
                _ => {
                    entries.images.insert(name, unpacked);
                }
            }
        }
        Ok(entries)
    }
}

fn last_part(name: &str) -> String {
    name.rsplit(['/', '\\']).next().unwrap_or_default().to_lowercase()
}

fn bounded(file: impl Read, limit: u64) -> Result<Vec<u8>, ObjArchiveError> {
    let mut bytes = Vec::new();
    if file.take(limit + 1).read_to_end(&mut bytes)? as u64 > limit {
        return Err(ObjArchiveError::TooLarge("a file"));
    }
    Ok(bytes)
}

/// Materials of the MTL files by name.
fn read_materials(entries: &Entries) -> Result<BTreeMap<String, Material>, ObjArchiveError> {
    let mut materials: BTreeMap<String, Material> = BTreeMap::new();
    let mut budget_px = Limits::PIXELS;
    for library in &entries.libraries {
        let mut current = String::new();
        for line in String::from_utf8_lossy(library).lines() {
            let (key, rest) = line.trim().split_once(char::is_whitespace).unwrap_or((line.trim(), ""));
            match key {
                "newmtl" => {
                    if materials.len() >= Limits::MATERIALS {
                        return Err(ObjArchiveError::TooLarge("more than 256 materials"));
                    }
                    current = rest.trim().to_owned();
                    let name = format!("material_{}", materials.len());
                    materials
                        .entry(current.clone())
                        .or_insert_with(|| Material::plain(&name, GRAY, ROUGHNESS));
                }
                "Kd" => {
                    let color = numbers::<3>(rest.split_ascii_whitespace());
                    if let (Some(material), Some(color)) = (materials.get_mut(&current), color) {
                        material.base_color = Rgb(color.map(|channel| channel.clamp(0.0, 1.0)));
                    }
                }
                "map_Kd" => {
                    // Options may precede the name.
                    let file =
                        entries.images.get(&last_part(rest.split_ascii_whitespace().last().unwrap_or("")));
                    if let (Some(material), Some(file)) = (materials.get_mut(&current), file) {
                        let image = decode_image(file, budget_px)?;
                        budget_px -= u64::from(image.width_px()) * u64::from(image.height_px());
                        material.base_color = Rgb([1.0; 3]);
                        material.base_color_texture = Some(Texture::new(image));
                    }
                }
                _ => {}
            }
        }
    }
    Ok(materials)
}

/// Base color of surfaces without a material.
const GRAY: Rgb = Rgb([0.8; 3]);
/// Roughness of all surfaces; MTL has none.
const ROUGHNESS: f32 = 0.7;

/// Indices of vertex, texture coordinate and normal, from 1; 0 = none.
type Corner = [usize; 3];

struct Reader<'a> {
    materials: &'a BTreeMap<String, Material>,
    positions: Vec<DVec3>,
    uvs: Vec<Vec2>,
    normals: Vec<Vec3>,
    corners: HashMap<Corner, u32>,
    /// Mesh vertices without a normal, with their OBJ vertex. They get the area-weighted mean normal of its faces.
    without_normal: Vec<(u32, usize)>,
    mesh: TexturedMesh,
    groups: BTreeMap<String, usize>,
    triangles: usize,
}

impl<'a> Reader<'a> {
    fn new(materials: &'a BTreeMap<String, Material>) -> Self {
        Self {
            materials,
            positions: Vec::new(),
            uvs: Vec::new(),
            normals: Vec::new(),
            corners: HashMap::new(),
            without_normal: Vec::new(),
            mesh: TexturedMesh::default(),
            groups: BTreeMap::new(),
            triangles: 0,
        }
    }

    fn read(mut self, text: &str) -> Result<TexturedMesh, ObjArchiveError> {
        let mut group: Option<usize> = None;
        let mut material = String::new();
        for (index, line) in text.lines().enumerate() {
            let broken = |what| ObjArchiveError::Line { line: index + 1, what };
            let mut words = line.split_ascii_whitespace();
            match words.next() {
                Some("v") => {
                    let [x, y, z] = numbers(words).ok_or_else(|| broken("three coordinates are expected"))?;
                    // From y up to z up.
                    self.positions.push(Vec3::new(x, -z, y).as_dvec3());
                }
                Some("vt") => {
                    let uv = numbers(words).ok_or_else(|| broken("two coordinates are expected"))?;
                    self.uvs.push(Vec2::from_array(uv));
                }
                Some("vn") => {
                    let [x, y, z] = numbers(words).ok_or_else(|| broken("three coordinates are expected"))?;
                    self.normals.push(Vec3::new(x, -z, y).normalize_or(Vec3::Z));
                }
                Some("usemtl") => {
                    material = line.trim_start().trim_start_matches("usemtl").trim().to_owned();
                    group = None;
                }
                Some("f") => {
                    let at = match group {
                        Some(at) => at,
                        None => self.group(&material)?,
                    };
                    group = Some(at);
                    self.face(words, at).map_err(broken)?;
                }
                _ => {}
            }
            let highest = self.positions.len().max(self.uvs.len()).max(self.normals.len());
            if highest.max(self.mesh.positions.len()) > Limits::VERTICES || self.triangles > Limits::TRIANGLES
            {
                return Err(ObjArchiveError::TooLarge("eight million vertices or triangles"));
            }
        }
        self.smooth();
        self.mesh.groups.retain(|group| !group.triangles.is_empty());
        Ok(self.mesh)
    }

    /// The face group of a material, created on first use.
    fn group(&mut self, material: &str) -> Result<usize, ObjArchiveError> {
        if let Some(at) = self.groups.get(material) {
            return Ok(*at);
        }
        if self.groups.len() > Limits::MATERIALS {
            return Err(ObjArchiveError::TooLarge("more than 256 materials"));
        }
        let number = self.mesh.materials.len();
        let unknown = || Material::plain(&format!("surface_{number}"), GRAY, ROUGHNESS);
        self.mesh.materials.push(self.materials.get(material).cloned().unwrap_or_else(unknown));
        self.mesh.groups.push(FaceGroup { material: number, triangles: Vec::new() });
        self.groups.insert(material.to_owned(), number);
        Ok(number)
    }

    /// Adds a polygon as a fan of triangles.
    fn face(&mut self, words: SplitAsciiWhitespace<'_>, group: usize) -> Result<(), &'static str> {
        let (mut first, mut last) = (None, None);
        for word in words {
            let corner = self.corner(word)?;
            let index = self.vertex(corner);
            let Some(first) = first else {
                first = Some(index);
                continue;
            };
            if let Some(last) = last {
                self.mesh.groups[group].triangles.push([first, last, index]);
                self.triangles += 1;
            }
            last = Some(index);
        }
        Ok(())
    }

    /// Parses `7/2/5`, `7//5`, `7/2` or `7`; negative numbers count from the end.
    fn corner(&self, word: &str) -> Result<Corner, &'static str> {
        let lengths = [self.positions.len(), self.uvs.len(), self.normals.len()];
        let mut corner = [0; 3];
        for ((slot, length), number) in corner.iter_mut().zip(lengths).zip(word.split('/')) {
            if number.is_empty() {
                continue;
            }
            let number: i64 = number.parse().map_err(|_| "a corner is no number")?;
            let from_start = if number < 0 { length as i64 + 1 + number } else { number };
            if from_start < 1 || from_start > length as i64 {
                return Err("a corner names something that is not there");
            }
            *slot = from_start as usize;
        }
        if corner[0] == 0 { Err("a corner has no vertex") } else { Ok(corner) }
    }

    fn vertex(&mut self, corner: Corner) -> u32 {
        if let Some(known) = self.corners.get(&corner) {
            return *known;
        }
        let index = self.mesh.positions.len() as u32;
        let [position, uv, normal] = corner;
        self.mesh.positions.push(self.positions[position - 1]);
        self.mesh.uvs.push(if uv == 0 { Vec2::ZERO } else { self.uvs[uv - 1] });
        self.mesh.normals.push(if normal == 0 { Vec3::ZERO } else { self.normals[normal - 1] });
        if normal == 0 {
            self.without_normal.push((index, position - 1));
        }
        self.corners.insert(corner, index);
        index
    }

    /// Fills in missing normals.
    fn smooth(&mut self) {
        if self.without_normal.is_empty() {
            return;
        }
        let mut at: Vec<Option<usize>> = vec![None; self.mesh.positions.len()];
        for (index, position) in &self.without_normal {
            at[*index as usize] = Some(*position);
        }
        let mut sums = vec![DVec3::ZERO; self.positions.len()];
        for t in self.mesh.triangles() {
            let [a, b, c] = t.map(|v| self.mesh.positions[v as usize]);
            let normal = (b - a).cross(c - a);
            t.iter().filter_map(|&v| at[v as usize]).for_each(|position| sums[position] += normal);
        }
        for (index, position) in &self.without_normal {
            self.mesh.normals[*index as usize] = sums[*position].normalize_or(DVec3::Z).as_vec3();
        }
    }
}

/// The first `N` words as finite numbers.
fn numbers<const N: usize>(mut words: SplitAsciiWhitespace<'_>) -> Option<[f32; N]> {
    let mut numbers = [0.0; N];
    for number in &mut numbers {
        *number = words.next()?.parse().ok().filter(|value: &f32| value.is_finite())?;
    }
    Some(numbers)
}

#[cfg(test)]
mod tests;

//! Mesh generators over vendors: the shared input image, vendor job and acceptance of the file. A [`MeshVendor`] adds
//! what differs.

use std::sync::Arc;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use bytes::Bytes;
use glam::DVec3;

use super::endpoint::Question;
use super::settings::{MeshSettings, TaskSettings};
use super::vendor_job::{JobSlots, LongQuestion, Protocol};
use super::{Endpoint, image};
use geometry::TexturedMesh;
use geometry::decimate::decimated;
use imaging::Image;
use mesh_io::gltf::{GltfError, read_mesh_glb};
use mesh_io::obj_archive::{ObjArchiveError, is_archive, read_mesh_obj_archive};
use ports::{
    Adapter, Answer, Call, Completion, MeshGenerator, Port, ProviderError, RawMesh, RawTable,
    ReconstructionRequest, TableRequest,
};
use scene::ReconstructionMethod;

/// Margin around the object, as a share of the side of the square.
const MARGIN: f64 = 0.1;

/// Maximum distance of a vertex of a decimated mesh from the surface, as a share of the longest edge.
const MAX_DEVIATION: f64 = 0.01;

/// Minimum extent of a mesh, as a share of its largest; a flatter mesh is a textured plane.
const MIN_EXTENT: f64 = 1e-4;

/// Reason why the file of a vendor is not used as a mesh.
#[derive(Debug, thiserror::Error)]
enum MeshRefused {
    #[error(transparent)]
    Glb(#[from] GltfError),
    #[error(transparent)]
    Archive(#[from] ObjArchiveError),
    #[error("the mesh has no triangle")]
    Empty,
    #[error("the mesh is flat: {:.3e} x {:.3e} x {:.3e}", .size.x, .size.y, .size.z)]
    Flat { size: DVec3 },
    #[error("the mesh has {triangles} triangles and cannot be reduced to {max_triangles}")]
    TooFine { triangles: usize, max_triangles: usize },
}

/// The requests of a vendor for meshes; its settings implement it.
pub trait MeshVendor: Protocol + Send + Sync {
    /// Name, model and the settings that decide the result.
    fn adapter(&self) -> Adapter;

    /// The question for a mesh of the object in a PNG file.
    fn question(&self, png: &[u8], seed: u64) -> Result<Question, ProviderError>;

    /// Input image and accepted mesh.
    fn mesh(&self) -> &MeshSettings;

    /// Limits of the vendor's jobs.
    fn task(&self) -> &TaskSettings;
}

/// The mesh generator of a vendor.
pub struct VendorMeshGenerator<V> {
    pub settings: V,
    pub endpoint: Arc<Endpoint>,
    pub slots: JobSlots,
}

impl<V: MeshVendor> VendorMeshGenerator<V> {
    /// A generator with as many concurrent jobs as the settings allow.
    pub fn new(settings: V, endpoint: Arc<Endpoint>) -> Self {
        let slots = JobSlots::new(settings.task());
        Self { settings, endpoint, slots }
    }

    async fn made(&self, call: &Call, request: ReconstructionRequest) -> Result<RawMesh, ProviderError> {
        let settings = self.settings.mesh();
        let hidden = request.completion.completed_share;
        let png = sent(call, request.completion, settings.image_px).await?;
        let question = self.settings.question(&png, request.seed)?;
        let long = LongQuestion {
            endpoint: &self.endpoint,
            slots: &self.slots,
            protocol: &self.settings,
            settings: self.settings.task(),
            question: &question,
        };
        let mesh = long.ask(call, |file| taken(call, file, settings)).await?;
        let Endpoint { provider, model, .. } = self.endpoint.as_ref();
        let mut notes = vec![format!("made by {model} from one image")];
        if hidden > 0.0 {
            notes.push(format!("{:.0} % of its outline was hidden and redrawn", 100.0 * hidden));
        }
        if !settings.licence_note.is_empty() {
            notes.push(settings.licence_note.clone());
        }
        let made_by = format!("{provider}, {model}");
        let method = ReconstructionMethod::Generated;
        Ok(RawMesh { mesh, method, made_by, licence: settings.licence.clone(), notes })
    }
}

impl<V: MeshVendor> MeshGenerator for VendorMeshGenerator<V> {
    fn adapter(&self) -> Adapter {
        self.settings.adapter()
    }

    fn reconstruct<'a>(&'a self, call: &'a Call, request: ReconstructionRequest) -> Answer<'a, RawMesh> {
        Box::pin(self.made(call, request))
    }

    fn table<'a>(&'a self, _call: &'a Call, _request: TableRequest) -> Answer<'a, RawTable> {
        let adapter = self.settings.adapter().name;
        Box::pin(async { Err(makes_no_tables(adapter)) })
    }
}

/// The object in the center of a transparent square, as a PNG file.
async fn sent(call: &Call, completion: Completion, side_px: u32) -> Result<Bytes, ProviderError> {
    call.compute(Port::MeshGenerator, move |_| {
        image::sent_cut_out(&squared(&completion.image, side_px), side_px).map_err(|error| {
            ProviderError::Rejected {
                port: Port::MeshGenerator,
                code: "image_unreadable",
                reason: format!("the image cannot be sent: {error}"),
            }
        })
    })
    .await
}

/// A PNG file as `data:` URL.
pub(super) fn data_url(png: &[u8]) -> String {
    format!("data:image/png;base64,{}", STANDARD.encode(png))
}

/// A square of `side_px` with the image centered within the margin; nearest-neighbor sampling.
fn squared(image: &Image, side_px: u32) -> Image {
    let (width, height) = (f64::from(image.width_px()), f64::from(image.height_px()));
    let side = f64::from(side_px);
    let scale = width.max(height).max(1.0) / (side * (1.0 - 2.0 * MARGIN));
    let mut square = Image::filled(side_px, side_px, [0; 4]);
    for v in 0..side_px {
        for u in 0..side_px {
            let x = 0.5 * width + (f64::from(u) + 0.5 - 0.5 * side) * scale;
            let y = 0.5 * height + (f64::from(v) + 0.5 - 0.5 * side) * scale;
            if x >= 0.0 && y >= 0.0 && x < width && y < height {
                square.set_pixel(u, v, image.pixel(x as u32, y as u32));
            }
        }
    }
    square
}

/// The file as a mesh of unit size within the maximum triangles; the inner error is why it is rejected.
async fn taken(
    call: &Call,
    file: Bytes,
    settings: &MeshSettings,
) -> Result<Result<TexturedMesh, MeshRefused>, ProviderError> {
    let max_triangles = settings.max_triangles;
    let mesh = move || sound(read(&file)?, max_triangles);
    call.compute(Port::MeshGenerator, move |_| Ok(mesh())).await
}

/// A GLB file, or a ZIP archive of an OBJ file, as one mesh, z up.
fn read(file: &[u8]) -> Result<TexturedMesh, MeshRefused> {
    Ok(match is_archive(file) {
        true => read_mesh_obj_archive(file)?,
        false => read_mesh_glb(file)?,
    })
}

/// The error of a vendor for a table: tables are catalog models, not reconstructions.
fn makes_no_tables(adapter: String) -> ProviderError {
    ProviderError::Unsupported {
        port: Port::MeshGenerator,
        adapter,
        reason: "it makes no tables; put embedded behind it in providers.mesh_generator".to_owned(),
    }
}

fn sound(mesh: TexturedMesh, max_triangles: usize) -> Result<TexturedMesh, MeshRefused> {
    if mesh.triangle_count() == 0 {
        return Err(MeshRefused::Empty);
    }
    let size = mesh.size_m();
    let longest = size.max_element();
    if !(longest.is_finite() && longest > 0.0 && size.min_element() >= MIN_EXTENT * longest) {
        return Err(MeshRefused::Flat { size });
    }
    let (low, high) = mesh.bounds();
    let mesh = mesh.translated(-0.5 * (low + high)).scaled(DVec3::splat(1.0 / longest));
    let mesh = match mesh.triangle_count() > max_triangles {
        true => decimated(&mesh, max_triangles, MAX_DEVIATION),
        false => mesh,
    };
    let triangles = mesh.triangle_count();
    if triangles > 2 * max_triangles {
        return Err(MeshRefused::TooFine { triangles, max_triangles });
    }
    Ok(mesh.snap_to_f32())
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{Material, Rgb, shapes};

    fn ball(segments: usize) -> TexturedMesh {
        let mut mesh = TexturedMesh::default();
        mesh.add(shapes::sphere(3.0, segments), &Material::plain("clay", Rgb([0.5; 3]), 0.5));
        mesh.translated(DVec3::new(10.0, -4.0, 2.0))
    }

    #[test]
    fn sound_scales_to_unit_size_and_decimates() {
        let fine = ball(64);
        assert!(fine.triangle_count() > 2000);
        let mesh = sound(fine, 2000).expect("is sound");
        assert!(mesh.triangle_count() <= 2000);
        assert!((mesh.size_m().max_element() - 1.0).abs() < 0.02, "{}", mesh.size_m());
        let (low, high) = mesh.bounds();
        assert!((low + high).abs().max_element() < 0.02);
    }

    #[test]
    fn sound_rejects_empty_flat_and_infinite_meshes() {
        assert!(sound(TexturedMesh::default(), 100).is_err());
        let flat = ball(16).scaled(DVec3::new(1.0, 1.0, 1e-6));
        assert!(matches!(sound(flat, 10_000), Err(MeshRefused::Flat { .. })));
        let mut broken = ball(16);
        broken.positions[3].x = f64::INFINITY;
        assert!(sound(broken, 10_000).is_err());
    }

    #[test]
    fn squared_centers_the_image_within_the_margin() {
        let square = squared(&Image::filled(40, 20, [9, 8, 7, 255]), 100);
        let covered = |x: u32, y: u32| square.pixel(x, y)[3] == 255;
        assert!(covered(50, 50) && covered(11, 50) && covered(88, 50) && covered(50, 31));
        assert!(!covered(9, 50) && !covered(91, 50) && !covered(50, 28) && !covered(50, 72));
    }
}

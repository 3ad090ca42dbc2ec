//! Transport of meshes, hulls and images between stages: as GLB, JSON and PNG bytes in the store.

use std::sync::Arc;

use super::Context;
use super::checkpoint::ArtifactRef;
use super::error::StageError;
use geometry::solid_query::{MeshSolid, SolidError};
use geometry::{ConvexHull, Material, Rgb, Solid, TexturedMesh, Vec2};
use imaging::codec::{decode_png, encode_png};
use imaging::{DepthImage, Image};
use mesh_io::gltf::{read_mesh_glb, reads_back_equal, write_mesh_glb};
use render::annotate::distinct_color;

/// Stores an image as PNG.
pub async fn put_image(context: &Context, name: &str, image: Image) -> Result<ArtifactRef, StageError> {
    let bytes = context.cpu(move || encode_png(&image)).await?;
    context.put(name, "image/png", bytes).await
}

/// Stores an image as PNG and keeps it for later stages of the job, which read it. The file of an `earlier` artifact
/// with the same image is stored again instead of being made again.
pub async fn put_input_image(
    context: &Context,
    name: &str,
    image: Image,
    earlier: Option<&ArtifactRef>,
) -> Result<ArtifactRef, StageError> {
    const PNG: &str = "image/png";
    if let Some(earlier) = earlier
        && *self::image(context, earlier).await? == image
    {
        let bytes = context.get(earlier).await?;
        return context.put(name, PNG, bytes).await;
    }
    let image = Arc::new(image);
    let encoded = image.clone();
    let bytes = context.cpu(move || encode_png(&encoded)).await?;
    let artifact = context.put(name, PNG, bytes).await?;
    // PNG cannot express an image without pixels.
    if !image.as_rgba().is_empty() {
        context.services().decoded.images.keep(&artifact.digest, &image);
    }
    Ok(artifact)
}

/// An image an earlier stage stored.
pub async fn image(context: &Context, artifact: &ArtifactRef) -> Result<Arc<Image>, StageError> {
    let decoded = &context.services().decoded;
    if let Some(image) = decoded.images.find(&artifact.digest) {
        return Ok(image);
    }
    let bytes = context.get(artifact).await?;
    let read = context.cpu(move || decode_png(&bytes)).await?;
    let image = Arc::new(read.map_err(|error| unreadable(artifact, error))?);
    decoded.images.keep(&artifact.digest, &image);
    Ok(image)
}

/// Stores a depth image as PNG.
pub async fn put_depth(context: &Context, name: &str, depth: DepthImage) -> Result<ArtifactRef, StageError> {
    let bytes = context.cpu(move || depth.encode_png()).await?;
    context.put(name, "image/png", bytes).await
}

/// A depth image an earlier stage stored.
pub async fn depth(context: &Context, artifact: &ArtifactRef) -> Result<Arc<DepthImage>, StageError> {
    let bytes = context.get(artifact).await?;
    let read = context.cpu(move || DepthImage::decode_png(&bytes, u64::MAX)).await?;
    Ok(Arc::new(read.map_err(|error| unreadable(artifact, error))?))
}

const GLB: &str = "model/gltf-binary";

/// Stores a mesh as GLB; positions are rounded to single precision, which the format holds. The mesh is kept for later
/// stages of the job where the file would give them the same one.
pub async fn put_mesh(context: &Context, name: &str, mesh: TexturedMesh) -> Result<ArtifactRef, StageError> {
    let write = move || {
        let mesh = mesh.snap_to_f32();
        (write_mesh_glb(&mesh), reads_back_equal(&mesh).then(|| Arc::new(mesh)))
    };
    let (bytes, same) = context.cpu(write).await?;
    let artifact = context.put(name, GLB, bytes).await?;
    if let Some(mesh) = same {
        context.services().decoded.meshes.keep(&artifact.digest, &mesh);
    }
    Ok(artifact)
}

/// A mesh an earlier stage stored.
pub async fn mesh(context: &Context, artifact: &ArtifactRef) -> Result<Arc<TexturedMesh>, StageError> {
    let decoded = &context.services().decoded;
    if let Some(mesh) = decoded.meshes.find(&artifact.digest) {
        return Ok(mesh);
    }
    let bytes = context.get(artifact).await?;
    let read = context.cpu(move || read_mesh_glb(&bytes)).await?;
    let mesh = Arc::new(read.map_err(|error| unreadable(artifact, error))?);
    decoded.meshes.keep(&artifact.digest, &mesh);
    Ok(mesh)
}

/// A mesh as a solid; `Err` says why it is none.
pub async fn solid(
    context: &Context,
    artifact: &ArtifactRef,
) -> Result<Result<Arc<MeshSolid>, SolidError>, StageError> {
    let decoded = &context.services().decoded;
    if let Some(solid) = decoded.solids.find(&artifact.digest) {
        return Ok(Ok(solid));
    }
    let mesh = mesh(context, artifact).await?;
    let made = context.cpu(move || MeshSolid::new(&mesh)).await?.map(Arc::new);
    if let Ok(solid) = &made {
        decoded.solids.keep(&artifact.digest, solid);
    }
    Ok(made)
}

/// Stores hulls twice: as numbers for the next stage, and as a colored mesh for people.
pub async fn put_hulls(context: &Context, hulls: &[ConvexHull]) -> Result<ArtifactRef, StageError> {
    let mesh = colored(hulls);
    let bytes = context.cpu(move || write_mesh_glb(&mesh.snap_to_f32())).await?;
    context.put("hulls.glb", GLB, bytes).await?;
    context.put_json("hulls.json", &hulls).await
}

/// Hulls an earlier stage stored.
pub async fn hulls(context: &Context, artifact: &ArtifactRef) -> Result<Vec<ConvexHull>, StageError> {
    context.get_json(artifact).await
}

/// Every hull in a color of its own.
fn colored(hulls: &[ConvexHull]) -> TexturedMesh {
    let mut mesh = TexturedMesh::default();
    for (index, hull) in hulls.iter().enumerate() {
        let [r, g, b, _] = distinct_color(index).map(|c| f32::from(c) / 255.0);
        let material = Material::plain(&format!("hull_{index}"), Rgb([r, g, b]), 0.8);
        let uvs = vec![Vec2::ZERO; hull.points.len()];
        mesh.add(Solid::from_corners(&hull.points, &uvs, &hull.triangles), &material);
    }
    mesh
}

fn unreadable(artifact: &ArtifactRef, error: impl std::error::Error + Send + Sync + 'static) -> StageError {
    StageError::permanent("artifact_unreadable", format!("artifact {} cannot be read", artifact.name))
        .because(error)
}

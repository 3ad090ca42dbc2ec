//! Operations of the tag `datasets`: frozen, verifiable sets of finished scenes.

use super::super::operation::Operation;
use crate::api::datasets::DatasetFiles;
use crate::api::datasets::DatasetPage;
use crate::api::datasets::views::DatasetView;
use crate::schemas::values::PathText;

/// `GET /datasets`.
pub fn list_datasets(operation: &mut Operation<'_>) {
    operation.is("datasets", "listDatasets", "Datasets, newest first; each freeze is an entry.");
    operation.answers::<DatasetPage>(200, "A page.");
}

/// `POST /datasets`.
pub fn submit_dataset(operation: &mut Operation<'_>) {
    operation.is(
        "datasets",
        "submitDataset",
        "Freeze a set of finished scenes as a version of a dataset, in the background.",
    );
    operation.explain(
        "The same set with the same request is no new version. Scenes that share a text, an \
         image, a mesh or an ancestor stay in one split unless `disjoint` says otherwise, and keep their \
         split in the next version.",
    );
    operation.answers::<DatasetView>(202, "Accepted; it waits or is being frozen.");
    operation.locates();
    operation.links("dataset", "getDataset", &[("dataset_id", "$response.body#/id")]);
    operation.links("files", "listDatasetFiles", &[("dataset_id", "$response.body#/id")]);
    operation.links("archive", "getDatasetArchive", &[("dataset_id", "$response.body#/id")]);
    operation.links("verification", "verifyDataset", &[("dataset_id", "$response.body#/id")]);
    operation.links("deletion", "deleteDataset", &[("dataset_id", "$response.body#/id")]);
    operation.refuses(&[409, 410, 507]);
}

/// `GET /datasets/{dataset_id}`.
pub fn get_dataset(operation: &mut Operation<'_>) {
    operation.is(
        "datasets",
        "getDataset",
        "The dataset, how far it is, its counts and what the last verification found.",
    );
    operation.answers::<DatasetView>(200, "The dataset.");
    operation.refuses(&[410]);
}

/// `DELETE /datasets/{dataset_id}`.
pub fn delete_dataset(operation: &mut Operation<'_>) {
    operation.is(
        "datasets",
        "deleteDataset",
        "Delete the dataset, cancel what is being done to it, and free its files; deleting twice is fine.",
    );
    operation.explain(
        "Other versions of the name, and the scenes, stay as they are. The number of a deleted version is not used \
         again while an earlier version of its name stays.",
    );
    operation.answers_nothing(204, "Deleted.");
}

/// `POST /datasets/{dataset_id}/verify`.
pub fn verify_dataset(operation: &mut Operation<'_>) {
    operation.is(
        "datasets",
        "verifyDataset",
        "Read every byte of a version again and compare it with the manifest, in the background.",
    );
    operation.answers::<DatasetView>(202, "The verification waits or is under way.");
    operation.locates();
    operation.refuses(&[409, 410]);
}

/// `GET /datasets/{dataset_id}/archive`.
pub fn get_dataset_archive(operation: &mut Operation<'_>) {
    operation.is(
        "datasets",
        "getDatasetArchive",
        "All files of a version as one tar archive; its bytes never change.",
    );
    operation.downloads(
        "The archive; as `application/octet-stream` for clients that accept only that.",
        &["application/x-tar"],
    );
    operation.refuses(&[409, 410]);
}

/// `GET /datasets/{dataset_id}/files`.
pub fn list_dataset_files(operation: &mut Operation<'_>) {
    operation.is(
        "datasets",
        "listDatasetFiles",
        "The files of a version: manifest, licenses, statistics and tar shards.",
    );
    operation.answers::<DatasetFiles>(200, "All files, by path.");
    operation.refuses(&[409, 410]);
}

/// `GET /datasets/{dataset_id}/files/{name}`.
pub fn get_dataset_file(operation: &mut Operation<'_>) {
    operation.is("datasets", "getDatasetFile", "A file of a version; its bytes never change.");
    operation.path_parameter::<PathText>(
        "name",
        "The path of the file, such as `shards/train-000000.tar`.",
        "dataset.json",
    );
    operation.downloads(
        "The file; as `application/octet-stream` for clients that accept only that.",
        &["application/json", "text/html", "text/markdown", "application/x-tar"],
    );
    operation.refuses(&[409, 410]);
}

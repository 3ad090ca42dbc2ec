"""Datasets in repositories of the Hugging Face Hub, by its package `huggingface_hub`, which is imported when called.

The Hub is the one of the environment variable `HF_ENDPOINT`, else huggingface.co; the token is the one given, else that
of `HF_TOKEN` or of `hf auth login`.
"""

from __future__ import annotations

import json
from pathlib import Path

from tabletopgen._media import imported

INFO = Path("meta", "info.json")


def push(folder: Path, repo_id: str, *, private: bool | None = None, token: str | None = None, message: str | None = None) -> str:
    """Uploads a folder as a dataset repository, which is made where there is none; files there that are not in the
    folder stay. A dataset for LeRobot gets the tag of its format's version, by which LeRobot finds it. Returns the
    repository's address."""
    api = imported("huggingface_hub").HfApi(token=token)
    # The package may tell the full name, with that of the user before it.
    repo = api.create_repo(repo_id, repo_type="dataset", private=private, exist_ok=True)
    api.upload_folder(repo_id=repo.repo_id, repo_type="dataset", folder_path=folder, commit_message=message)
    if (folder / INFO).is_file():
        version = json.loads((folder / INFO).read_text(encoding="utf-8"))["codebase_version"]
        # A tag of an earlier upload would keep naming that.
        if any(ref.name == version for ref in api.list_repo_refs(repo.repo_id, repo_type="dataset").tags):
            api.delete_tag(repo.repo_id, tag=version, repo_type="dataset")
        api.create_tag(repo.repo_id, tag=version, repo_type="dataset")
    return str(repo)

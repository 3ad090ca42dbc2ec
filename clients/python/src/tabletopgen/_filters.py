"""What lists of scenes are filtered by."""

from __future__ import annotations

from datetime import datetime
from typing import Literal, cast

from typing_extensions import TypedDict

from tabletopgen._requests import Query


class SceneFilters(TypedDict, total=False):
    """Filters of `scenes` and `facets`; those that are left out let every scene pass, but for deleted ones."""

    #: Deleted scenes only where they are asked for.
    state: Literal["pending", "ready", "failed", "deleted"] | None
    verdict: Literal["pass", "quarantine"] | None
    #: Source of the scene.
    kind: Literal["text", "image", "edit", "variant"] | None
    #: Words of the text of the request, all of them.
    q: str | None
    #: `key:value`.
    label: str | None
    #: A category that an object of the scene has, such as `mug`.
    category: str | None
    min_objects: int | None
    max_objects: int | None
    #: UUID of the scene that it was made from.
    parent: str | None
    #: With a time zone.
    created_after: datetime | None


def query_of(filters: SceneFilters) -> Query:
    """The same, for a request; all of its fields are of the types of a query."""
    return cast("Query", filters)

"""Exceptions of the client. A refusal by the server is an `ApiError`, with a class for each type of problem."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Protocol

from tabletopgen.models import FieldError, LimitUse

PREFIX = "urn:tabletopgen:problem:"


class TabletopgenError(Exception):
    """Anything that this package raises on purpose."""


class ProgramMissingError(TabletopgenError):
    """No program `tabletopgen` to run a local server with."""


class LocalServerError(TabletopgenError):
    """A local server that did not start, with the end of its log."""


class ConnectionFailedError(TabletopgenError):
    """A server that could not be reached, or an answer that broke off, for longer than the client's patience."""


class DownloadDamagedError(TabletopgenError):
    """A file whose bytes are not those of its digest."""


class MissingPackageError(TabletopgenError, ImportError):
    """A method that needs an optional package, which is not installed."""


class WaitTimeoutError(TabletopgenError, TimeoutError):
    """Work of the server that did not end within the time that the caller gave it. It goes on."""


class Failure(Protocol):
    """The reason that the server states for work that failed."""

    @property
    def code(self) -> str: ...
    @property
    def message(self) -> str: ...


class WorkFailedError(TabletopgenError):
    """Work of the server that failed or was cancelled: `code` and `detail` say why."""

    def __init__(self, what: str, failure: Failure | None, state: str):
        self.failure = failure
        self.code = failure.code if failure else state
        self.detail = failure.message if failure else f"it is {state}"
        super().__init__(f"{what}: {self.detail} ({self.code})")


class ApiError(TabletopgenError):
    """A refusal (RFC 9457): `detail` states the correction, `code` is stable, `errors` point into the body."""

    # The end of the type of the problem, after the prefix.
    kind: ClassVar[str] = ""

    def __init__(self, status: int, problem: Mapping[str, Any], request: str = ""):
        self.status = status
        self.type = str(problem.get("type", ""))
        self.code = str(problem.get("code", ""))
        self.detail = str(problem.get("detail", ""))
        self.request_id = problem.get("request_id")
        self.errors = [FieldError.model_construct(**error) for error in problem.get("errors") or ()]
        limit = problem.get("limit")
        self.limit = LimitUse.model_construct(**limit) if limit else None
        words = [f"{request}: {self.detail or 'no reason was given'} ({self.code or 'no code'}, status {status})"]
        words += [f"  {error.pointer or '/'}: {error.detail}" for error in self.errors]
        if status >= 500 and self.request_id:
            words.append(f"  request {self.request_id}, as in the log of the server")
        super().__init__("\n".join(words))

    @property
    def pointers(self) -> list[str]:
        """JSON pointers of the faults of the body."""
        return [error.pointer for error in self.errors]


class MalformedRequestError(ApiError):
    kind = "malformed-request"


class InvalidRequestError(ApiError):
    kind = "invalid-request"


class UnauthorizedError(ApiError):
    kind = "unauthorized"


class ForbiddenError(ApiError):
    kind = "forbidden"


class NotFoundError(ApiError):
    kind = "not-found"


class MethodNotAllowedError(ApiError):
    kind = "method-not-allowed"


class RequestTimeoutError(ApiError):
    kind = "request-timeout"


class ConflictError(ApiError):
    kind = "conflict"


class GoneError(ApiError):
    kind = "gone"


class PreconditionFailedError(ApiError):
    kind = "precondition-failed"


class PayloadTooLargeError(ApiError):
    kind = "payload-too-large"


class UnsupportedMediaTypeError(ApiError):
    kind = "unsupported-media-type"


class RangeNotSatisfiableError(ApiError):
    kind = "range-not-satisfiable"


class MisdirectedRequestError(ApiError):
    kind = "misdirected-request"


class TooManyRequestsError(ApiError):
    kind = "too-many-requests"


class InternalError(ApiError):
    kind = "internal"


class UnavailableError(ApiError):
    kind = "unavailable"


class InsufficientStorageError(ApiError):
    kind = "insufficient-storage"


BY_TYPE = {f"{PREFIX}{error.kind}": error for error in ApiError.__subclasses__()}


def refusal(status: int, problem: Mapping[str, Any], request: str = "") -> ApiError:
    """The exception for an answer; `problem` is empty where the answer was no problem document."""
    return BY_TYPE.get(str(problem.get("type")), ApiError)(status, problem, request)

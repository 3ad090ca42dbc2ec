"""The base of the models of answers and requests."""

from pydantic import BaseModel, ConfigDict


class Model(BaseModel):
    """Named fields of JSON. Fields that a newer server adds are kept, and those of requests are sent as they are."""

    model_config = ConfigDict(extra="allow")

"""Client of tabletopgen: a sentence or an image becomes a tabletop scene for robot simulation.

    from tabletopgen import Client

    with Client() as client:
        scene = client.generate("A desk with a laptop, a mug and two books", seed=7).wait()
        model = scene.mujoco()

`AsyncClient` has the same methods, to await. `models` are the schemas of the contract, `errors` the exceptions.
"""

from tabletopgen import errors, models, webhooks
from tabletopgen._async.batch import AsyncBatch
from tabletopgen._async.client import AsyncClient, AsyncMapped
from tabletopgen._async.dataset import AsyncDataset
from tabletopgen._async.execution import AsyncExecution
from tabletopgen._async.recording import AsyncRecording
from tabletopgen._async.scene import AsyncScene
from tabletopgen._async.webhook import AsyncWebhook
from tabletopgen._filters import SceneFilters
from tabletopgen._sync.batch import Batch
from tabletopgen._sync.client import Client, Mapped
from tabletopgen._sync.dataset import Dataset
from tabletopgen._sync.execution import Execution
from tabletopgen._sync.recording import Recording
from tabletopgen._sync.scene import Scene
from tabletopgen._sync.webhook import Webhook

__version__ = "0.1.0"
__all__ = [
    "AsyncBatch",
    "AsyncClient",
    "AsyncDataset",
    "AsyncExecution",
    "AsyncMapped",
    "AsyncRecording",
    "AsyncScene",
    "AsyncWebhook",
    "Batch",
    "Client",
    "Dataset",
    "Execution",
    "Mapped",
    "Recording",
    "Scene",
    "SceneFilters",
    "Webhook",
    "errors",
    "models",
    "webhooks",
]

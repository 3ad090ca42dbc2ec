"""What the parts share: services with keys, clients of tenants, and the secrets that were given out."""

import contextlib
import json

from tabletopgen_checks.bars.reliability.bench import Bench, Service
from tabletopgen_checks.bars.tenants.secrets import Secrets
from tabletopgen_checks.processes import output_of
from tabletopgen_checks.service.server import Server

KEYS = {"server.authentication.mode": "keys"}
ALL_SCOPES = "read,submit,delete,operate,admin"


class TenantBench(Bench):
    def __init__(self, given):
        super().__init__(given, "tenants")
        self.secrets = Secrets()

    @contextlib.contextmanager
    def keyed(self, store: str, name: str, settings: dict, **more):
        """A service that wants keys. Before it goes, its logs and rows are searched for secrets."""
        with self.service(store, name, settings=settings | KEYS, **more) as service:
            yield service
            self.secrets.search_service(service)

    def client(self, service: Service, tenant: str = "default", scopes: str = ALL_SCOPES, more=()) -> Server:
        """One who asks the service with a new key of a tenant."""
        made = json.loads(command(service, "keys", "create", "--name", tenant, "--tenant", tenant, "--scopes", scopes, "--json", *more))
        return service.api.as_client(self.secrets.add(f"key of {tenant}", made["key"]))


def command(service: Service, *words) -> str:
    """What a command of the operator prints, beside the running service."""
    place = ["--data-dir", service.api.data]
    for key, value in service.storage("api", service.users[service.api]).items():
        place += ["--set", f"{key}={value}"]
    return output_of(service.bench.binary, *words, *place)

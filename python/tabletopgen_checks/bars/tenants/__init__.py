"""Keys and tenants: who may do what, what tenants notice of each other, where secrets go, what deletion leaves, what a
key costs.
"""

DEPENDS_ON = (
    "config/default.toml",
    "crates/server/store",
    "migrations",
    "openapi.yaml",
    "src/api",
    "src/api.rs",
    "src/service",
    "src/service.rs",
    "src/worker",
    "src/worker.rs",
    "tests/contract",
    "tests/it/api/access.rs",
)

"""`tabletopgen mcp`, spoken to by the protocol's own client."""

import asyncio
import base64
import io
import json
import os
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import PIL.Image
import pytest
from mcp import ClientSession, StdioServerParameters
from mcp.client.stdio import stdio_client
from mcp.types import CallToolResult, ImageContent, TextContent

COMMAND = os.environ.get("TABLETOPGEN_PROGRAM", "tabletopgen")


def spoken(folder: Path, talk: Callable[[ClientSession], Awaitable[None]]) -> None:
    """Starts the program in a folder, and talks to it."""

    async def run() -> None:
        given = StdioServerParameters(command=COMMAND, args=["mcp"], cwd=str(folder))
        async with stdio_client(given) as (read, write), ClientSession(read, write) as session:
            about = await session.initialize()
            assert about.server_info.name == "tabletopgen"
            await talk(session)

    asyncio.run(run())


def document(result: CallToolResult) -> Any:
    assert not result.is_error, result
    return json.loads(text(result))


def text(result: CallToolResult) -> str:
    first = result.content[0]
    assert isinstance(first, TextContent)
    return first.text


def preview(result: CallToolResult) -> PIL.Image.Image:
    (found,) = [part for part in result.content if isinstance(part, ImageContent)]
    return PIL.Image.open(io.BytesIO(base64.b64decode(found.data)))


def test_a_scene_is_made_edited_inspected_and_acted_in(tmp_path: Path) -> None:
    async def talk(session: ClientSession) -> None:
        tools = {tool.name: tool for tool in (await session.list_tools()).tools}
        assert {"generate", "edit", "inspect", "tasks", "execute", "episodes"} <= set(tools)
        assert all(tool.description for tool in tools.values())
        made = await session.call_tool("generate", {"scene": "desk", "text": "A desk with a mug and a plate", "seed": 7})
        assert document(made)["verdict"] == "pass"
        assert preview(made).size == (960, 720)
        edit = {"scene": "desk", "text": "move the mug to the left of the plate", "new_scene": "desk2", "seed": 7}
        assert document(await session.call_tool("edit", edit))["verdict"] == "pass"
        seen = await session.call_tool("inspect", {"scene": "desk2"})
        at = {item["name"]: item["translation_m"] for item in document(seen)["instances"]}
        assert at["mug_1"][0] < at["plate_1"][0]
        proposed = document(await session.call_tool("tasks", {"scene": "desk", "count": 2}))["proposed"]
        assert len(proposed) == 2
        doing = {"scene": "desk", "task": "put the mug on the plate", "out": "run"}
        assert document(await session.call_tool("execute", doing))["execution"]["succeeded"]
        assert document(await session.call_tool("list", {})) == {"scenes": ["desk", "desk2"], "other_folders": ["run"]}

    spoken(tmp_path, talk)
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["desk", "desk2", "run"]


@pytest.mark.parametrize(
    ("tool", "given", "says"),
    [
        ("inspect", {"scene": "../secret"}, "is no name"),
        ("inspect", {"scene": "none"}, "there is no none"),
        ("generate", {"scene": "/etc/x", "text": "a mug"}, "is no name"),
        ("generate", {"scene": "x", "text": "--help"}, ""),
        ("generate", {"scene": "x", "text": " "}, "describe a table"),
        ("generate", {"scene": "x"}, "text"),
        ("generate", {"scene": "x", "text": "a mug", "config": "mine.toml"}, "config"),
        ("execute", {"scene": "secret", "task": "secret/scene.json", "out": "run"}, "there is no secret"),
        # Neither a file that is there nor one that is not: the answer tells no difference.
        ("execute", {"scene": "desk", "task": "secret/scene.json", "out": "run"}, "not a file"),
        ("episodes", {"scene": "desk", "task": "secret/none.json", "count": 1, "out": "run"}, "not a file"),
    ],
)
def test_what_will_not_do_is_an_answer_that_says_why(tmp_path: Path, tool: str, given: dict[str, str], says: str) -> None:
    (tmp_path / "secret").mkdir()
    (tmp_path / "out" / "desk").mkdir(parents=True)
    (tmp_path / "secret" / "scene.json").write_text('"secret"')

    async def talk(session: ClientSession) -> None:
        try:
            result = await session.call_tool(tool, given)
        except Exception as error:  # noqa: BLE001  # The client has an error type of its own for protocol errors.
            assert says in str(error)
            return
        assert "secret" not in text(result)
        assert says in text(result)

    spoken(tmp_path, talk)

"""A server and a client."""

from collections.abc import Iterator

import pytest
from agent_side import CARD, Agent, parameters
from anyio.from_thread import BlockingPortal, start_blocking_portal
from mcp import Client


@pytest.fixture(scope="package")
def portal() -> Iterator[BlockingPortal]:
    """An event loop in a thread."""
    with start_blocking_portal() as portal:
        yield portal


@pytest.fixture(scope="package")
def agent(tmp_path_factory: pytest.TempPathFactory, portal: BlockingPortal) -> Iterator[Agent]:
    """An agent and its server, which serves a folder of its own to all tests."""
    root = tmp_path_factory.mktemp("served")
    card = root / ".cards" / "seen-in-a-test" / "card.yaml"
    card.parent.mkdir(parents=True)
    card.write_text(CARD, "utf-8")
    with portal.wrap_async_context_manager(Client(parameters(root))) as client:
        yield Agent(client, portal, root)

"""One language server for all tests; without Node, or without a network the first time, they are skipped."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from language_server import NoServer, Server, server_command

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="session")
def command(npm: None) -> list[str]:
    """Return the command of the server."""
    try:
        return server_command()
    except NoServer as error:
        pytest.skip(f"no yaml-language-server: {error}")


@pytest.fixture(scope="session")
def server(command: list[str]) -> Iterator[Server]:
    """Return a server that knows nothing but what the files say."""
    server = Server(command)
    yield server
    server.close()


@pytest.fixture
def case() -> Path:
    """Return where the probed texts pretend to stand: beside the cases."""
    return ROOT / "cases" / "probe" / "case.yaml"

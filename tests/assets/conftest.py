"""Model files written into a case's folder, and why they are refused."""

from collections.abc import Callable
from pathlib import Path

import pytest

from tests.assets.models import TETRAHEDRON
from text2sim.assets.mechanism import load_mechanism
from text2sim.spec_schema.errors import AssetError

Write = Callable[..., Path]
Refused = Callable[..., str]


@pytest.fixture
def write(tmp_path: Path) -> Write:
    """Write files into a case's folder, which comes with a mesh."""

    def make(files: dict[str, str | bytes]) -> Path:
        for name, content in {"meshes/part.obj": TETRAHEDRON, **files}.items():
            path = tmp_path / "case" / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return tmp_path / "case"

    return make


@pytest.fixture
def refused(write: Write) -> Refused:
    """Return why a document is refused."""

    def reason(text: str | bytes, name: str = "m.xml", **more: str) -> str:
        with pytest.raises(AssetError) as found:
            load_mechanism(write({name: text, **more}), name)
        return str(found.value)

    return reason

"""Compression of pictures to a size that fits into a message."""

from io import BytesIO
from typing import TYPE_CHECKING

from text2sim.mcp_server.answers import MAX_PICTURE

if TYPE_CHECKING:
    from PIL.Image import Image


def compressed(png: bytes) -> tuple[bytes, str]:
    """Return a PNG as a JPEG, and its type."""
    from PIL import Image

    with Image.open(BytesIO(png)) as picture:
        return jpeg(picture.convert("RGB")), "image/jpeg"


def jpeg(picture: "Image") -> bytes:
    """Return a picture as a JPEG of limited size; quality is reduced first, then resolution."""
    for quality in (88, 75, 60):
        stream = BytesIO()
        picture.save(stream, "JPEG", quality=quality, optimize=True)
        if stream.tell() <= MAX_PICTURE:
            return stream.getvalue()
    picture = picture.resize((max(1, picture.width // 2), max(1, picture.height // 2)))
    stream = BytesIO()
    picture.save(stream, "JPEG", quality=60)
    return stream.getvalue()

"""Admission to a page that stands on this machine: by its secret, and under its own name."""

import secrets
from collections.abc import Collection, Mapping

HEADERS = {
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "X-Frame-Options": "DENY",
}
"""Of every answer."""


def policy(nonce: str, forms: str = "'none'") -> str:
    """Return what a page may do: nothing but run our script and style, which have the nonce, and ask us."""
    only = f"'nonce-{nonce}'"
    return (
        f"default-src 'none'; script-src {only}; style-src {only}; img-src data:; media-src 'self'; "
        f"connect-src 'self'; base-uri 'none'; form-action {forms}; frame-ancestors 'none'"
    )


def admitted(target: str, headers: Mapping[str, str], hosts: Collection[str], token: str) -> str | None:
    """Return what is asked for, below the secret; None for whoever does not know it, or comes from elsewhere.

    Args:
        target: Path of the request.
        headers: Of the request.
        hosts: Names with ports under which we are asked.
        token: The secret.
    """
    origin = headers.get("Origin")
    if headers.get("Host") not in hosts or (origin and origin.removeprefix("http://") not in hosts):
        return None
    # A link in a letter may lead here; what other pages fetch, embed or send is refused.
    followed = headers.get("Sec-Fetch-Mode") == "navigate" and headers.get("Sec-Fetch-Dest") == "document"
    if headers.get("Sec-Fetch-Site", "none") not in ("none", "same-origin") and not followed:
        return None
    given, slash, path = target.removeprefix("/").partition("/")
    if not slash or not secrets.compare_digest(given.encode("utf-8", "replace"), token.encode()):
        return None
    return path

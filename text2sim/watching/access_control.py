"""Access control of pages that are served on this machine: by a secret in the address and by host name."""

import secrets
from collections.abc import Collection, Mapping

HEADERS = {
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "X-Frame-Options": "DENY",
}
"""Headers of every answer."""


def content_security_policy(nonce: str, form_action: str = "'none'") -> str:
    """Return the content security policy of a page, which allows only our scripts, styles and server."""
    nonce_source = f"'nonce-{nonce}'"
    return (
        f"default-src 'none'; script-src {nonce_source}; style-src {nonce_source}; img-src data:; media-src 'self'; "
        f"connect-src 'self'; base-uri 'none'; form-action {form_action}; frame-ancestors 'none'"
    )


def admitted_path(target: str, headers: Mapping[str, str], hosts: Collection[str], token: str) -> str | None:
    """Return the path below the secret; None if the secret is wrong, or the request comes from another page.

    Args:
        target: Path of the request.
        headers: Headers of the request.
        hosts: Our host names with ports.
        token: The secret.
    """
    origin = headers.get("Origin")
    if headers.get("Host") not in hosts or (origin and origin.removeprefix("http://") not in hosts):
        return None
    # Links may be followed from anywhere; requests, frames and forms of other pages are refused.
    is_link = headers.get("Sec-Fetch-Mode") == "navigate" and headers.get("Sec-Fetch-Dest") == "document"
    if headers.get("Sec-Fetch-Site", "none") not in ("none", "same-origin") and not is_link:
        return None
    given_token, slash, path = target.removeprefix("/").partition("/")
    if not slash or not secrets.compare_digest(given_token.encode("utf-8", "replace"), token.encode()):
        return None
    return path

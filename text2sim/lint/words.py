"""Numbers as findings say them."""


def length(value: float) -> str:
    """Return a length [m] in words: `12 mm`, `1.5 m`."""
    if 1000.0 <= abs(value) < 1e6:
        return f"{value:,.0f} m"
    return f"{value:.3g} m" if abs(value) >= 1.0 else f"{value * 1000:.3g} mm"


def vector(values: tuple[float, ...]) -> str:
    """Return a vector as the case writes it."""
    return "[" + ", ".join(f"{value + 0.0:.4g}" for value in values) + "]"


def more_copies(count: int, what: str = "of its copies") -> str:
    """Return what stands behind the first of several copies: ` (and 3 more of its copies)`."""
    return f" (and {count - 1} more {what})" if count > 1 else ""

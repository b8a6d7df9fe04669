"""Numbers in messages."""

from text2sim.spec_schema.rounding import at_least, at_most


def length(value: float) -> str:
    """Return a length [m] with its unit: `12 mm`, `1.5 m`."""
    if 1000.0 <= abs(value) < 1e6:
        return f"{value:,.0f} m"
    return f"{value:.3g} m" if abs(value) >= 1.0 else f"{value * 1000:.3g} mm"


def length_of_at_least(value: float) -> str:
    """Return a length [m] with its unit, with two digits, rounded up."""
    return length(float(at_least(value)))


def length_of_at_most(value: float) -> str:
    """Return a length [m] with its unit, with two digits, rounded down."""
    return length(float(at_most(value)))


def vector(values: tuple[float, ...]) -> str:
    """Return a vector as in a case."""
    return "[" + ", ".join(f"{value + 0.0:.4g}" for value in values) + "]"


def more_copies(count: int, what: str = "of its copies") -> str:
    """Return the suffix after the first of several copies: ` (and 3 more of its copies)`."""
    if count == 2:
        what = what.replace("pairs", "pair")
    return f" (and {count - 1} more {what})" if count > 1 else ""


def amount(value: float, unit: str) -> str:
    """Return a value with three digits and its unit, without an exponent from 1 to a million."""
    text = f"{float(f'{value:.3g}'):.0f}" if 1e3 <= abs(value) < 1e6 else f"{value:.3g}"
    return f"{text} {unit}".rstrip()


def as_radians(degrees: float) -> str:
    """Return advice on how to write an angle in degrees as one in radians: `45 deg is ${radians(45)}`."""
    return f"{degrees:g} deg is ${{radians({degrees:g})}}"

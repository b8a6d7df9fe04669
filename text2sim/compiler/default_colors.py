"""Colours of bodies and statics that were given none."""

from text2sim.spec_schema.models.case import Case

STATIC_COLOR = "#98a1a9"
"""Statics without a colour: grey, so that bodies stand out."""
MATERIAL_COLORS = {"granular": "#c8a96a", "liquid": "#3f88c5", "snow": "#f1f4f7"}
"""Bodies that have the colour of their material if they are given none."""
# Okabe and Ito's palette, which people with every kind of colour vision can tell apart
# (https://jfly.uni-koeln.de/color/), for bodies that were given no colour.
PALETTE = ("#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00", "#f0e442")


def default_colors(case: Case) -> dict[str, str]:
    """Return the colour that each body and static has where it is given none, by name.

    It follows from the name of a body, so that it stays as other bodies come and go; only a body whose colour an
    earlier one has takes the next that is free.
    """
    colors = dict.fromkeys(case.scene.statics, STATIC_COLOR)
    taken: set[str] = set()
    for name, body in case.bodies.items():
        first = sum(name.encode()) % len(PALETTE)
        free = [color for color in (*PALETTE[first:], *PALETTE[:first]) if color not in taken]
        colors[name] = MATERIAL_COLORS.get(body.kind) or (free[0] if free else PALETTE[first])
        if body.look.color is None:
            taken.add(colors[name])
    return colors

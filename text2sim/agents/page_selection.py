"""Tables for the selection of pages: which parts of the language each reader gets, and which words require more."""

import re

from text2sim.spec_schema.models.bodies import LINKED
from text2sim.spec_schema.models.soft_bodies import FLOWING

PAGES_BY_READER: dict[str, tuple[str, ...]] = {
    "scene": ("`scene`: the stage", "Statics", "Settings of the scene", "Solvers of deformable bodies", "Shapes",
              "Parts of a compound", "Parts of a sculpt", "Cross-sections", "Poses and places",
              "Materials, joints and looks", "Copies"),
    "bodies": ("`bodies`: the actors", "Mounts", "Parts of articulated bodies and chains", "Motions", "Shapes",
               "Shapes of cloth", "Parts of a compound", "Parts of a sculpt", "Cross-sections", "Poses and places",
              "Copies", "Regions of space",
               "Materials, joints and looks", "Materials of deformable bodies"),
    "actions": ("`actions`: the script", "Controls", "Schedules", "Measures", "Events", "Expectations",
                "Regions of space", "Regions on bodies"),
    "expectations": ("Measures", "Events", "Expectations"),
    "render": ("`render`: the film", "Shots and overlays", "Cameras", "Lights"),
}  # fmt: skip
"""Titles of the pages that each reader gets."""
INDEXED_PAGES = ("`bodies`: the actors", "Shapes", "Shapes of cloth", "Mounts", "Controls", "Copies")
"""Pages whose kinds the Planner sees, one line each."""
MPM = frozenset({"soft", *FLOWING})
JOINTED = frozenset({"hinge", "slider", "ball", *LINKED})
MOTORED = frozenset({"hinge", "slider", "articulated"})
"""Kinds with joints that a motor may drive."""
DEFORMABLE_KINDS = MPM | {"cloth"}
COPIES = frozenset({"line", "grid", "ring", "spiral", "stack", "running_bond", "packing", "glyphs", "fragments"})
KINDS_BY_MODEL: dict[str, frozenset[str]] = {
    "Contact": DEFORMABLE_KINDS | {"fem", "ipc", "pairs"}, "Solver": frozenset({"newton", "cg"}),
    "Material": frozenset(), "Look": frozenset(), "Pose": frozenset(),
    "Mpm": MPM, "Pbd": frozenset({"cloth"}), "Fem": frozenset({"fem"}), "Ipc": frozenset({"ipc"}),
    "JointDynamics": frozenset({"articulated"}), "Actuator": MOTORED,
    "Palette": COPIES, "Vary": COPIES,
    "SoftMaterial": frozenset({"soft"}), "ClothMaterial": frozenset({"cloth"}),
    "GranularMaterial": frozenset({"granular"}), "LiquidMaterial": frozenset({"liquid"}),
    "SnowMaterial": frozenset({"snow"}), "Link": frozenset({"articulated"}), "Loop": frozenset({"articulated"}),
    "JointOverride": frozenset({"articulated"}), "Payload": frozenset({"chain"}), "Shot": frozenset(),
    "BodyRegion": frozenset(), "BodyPoint": frozenset(), "Part": frozenset({"compound"}),
}  # fmt: skip
"""Models of pages, and the kinds that require their description; an empty set means always. Others are on demand."""
KINDS_BY_PAGE: dict[str, frozenset[str]] = {
    "Motions": frozenset({"driven"}), "Shapes of cloth": frozenset({"cloth"}), "Mounts": JOINTED | {"free", "fixed"},
    "Parts of a compound": frozenset({"compound"}), "Parts of a sculpt": frozenset({"sculpt"}),
    "Cross-sections": frozenset({"sculpt"}), "Copies": COPIES,
    "Regions of space": frozenset({"packing", "enters", "leaves", "count_in", "share_in", "surface_level"}),
    "Lights": frozenset({"sun", "softbox", "lamp", "spot", "sky", "environment", "light", "lights"}),
    "Regions on bodies": frozenset({"cloth", "soft", "point", "region", "corner", "edge", "face"}),
}  # fmt: skip
"""Pages, and the kinds that require them; other pages are always included."""
FIELD_CONTROLS = frozenset({"wind", "airflow", "drag", "attraction", "vortex", "turbulence"})
"""Controls that act on deformable bodies alone; in a plan without any, they are everyday words."""
BODY_WORDS = {
    "beam": frozenset({"slat", "springboard", "ruler", "reed", "cantilever"}),
    "cone": frozenset({"frustum"}),
    "revolve": frozenset({"dome"}),
}
"""Everyday words for things that this kind fits better than any other."""
CONTROL_WORDS = {
    "attach": frozenset({
        "tie", "ties", "tied", "held", "pinned", "fastened", "hang", "hangs", "sewn", "welded", "attachments", "seam",
        "seams", "stitch", "stitches", "stitched", "stitching", "sew", "rip", "rips",
    }),
    "spring": frozenset({"springs", "sprung", "coil", "bungee", "elastic", "slingshot"}),
    "release": frozenset({"let", "lets", "freed", "loose", "snap", "snaps"}),
}  # fmt: skip
"""Everyday words for controls, in a brief."""
IN_STAGES = frozenset({
    "back", "return", "returns", "again", "twice", "between", "fro", "then", "until", "kept", "keeps", "holds",
})  # fmt: skip
"""Words of a brief for a motion or a strength of several stages."""
LIGHT_WORDS = re.compile(
    r"\b(?:grazing|raking|backlit|backlight|sidelight|spotlight|light\b[^.,;]{0,40}\bfrom)\b", re.IGNORECASE
)
"""Words of a brief that asks for light from a direction."""
BELT = "belt"
"""Word among the kinds for statics whose surfaces move."""
BELT_WORDS = frozenset({BELT, "belts", "conveyor", "conveyors", "treadmill", "treadmills", "surface_velocity"})
"""Words of a plan for such statics."""
CONTROLS_OF_EVENTS = {"released": ("attach", "release"), "removed": ("remove",), "broken": ("bond", "attach")}
"""Controls without which there is no such event."""
SOFT_FIELDS = ("touch_soft", "soft_reach", "mpm", "pbd", "fem", "ipc")
"""Fields that concern deformable bodies alone."""
PLANNER_PAGES = ("Measures", "Events", "Expectations", "Regions of space")
"""Pages about parts that the Planner writes; the Action Writer needs them only to add its own."""
ALWAYS_DESCRIBED = frozenset({"ramp", "still"})
"""Kinds that are described to every reader of their page."""
EVERYDAY_KINDS = frozenset({"ball", "line", "text", "free", "still", "box", "rigid", "sphere", "reach"})
"""Kinds that are everyday words or need no explanation."""
FULLY_DESCRIBED = frozenset({"pattern", "label", "vary", "palette", "overlay"})
"""Models that are described with all fields if an instruction names them."""
PLACING_WORDS = frozenset({"place", "placed", "add", "added", "adds", "another", "new", "second"})
"""Words of an instruction that may place something."""
TURNING_WORDS = frozenset({"pose", "quat", "euler_deg", "turn", "turned", "tilt", "tilted", "rotate", "rotated"})
"""Words of an instruction that may only move or turn something."""

"""The bodies of falling_letters: everything that moves."""

from pathlib import Path

import genesis as gs
from filling import weigh

HERE = Path(__file__).resolve().parent

# What deforms: kind of body, solver, distance of its points at rest [m], where its frame is placed.
DEFORMABLES = {
    "letter[0]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.01152,
        "pos": (-0.284883674, 0.0, 1.77888384),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "letter[1]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.01152,
        "pos": (-0.13141302, 0.0, 1.78222074),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "letter[2]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.01152,
        "pos": (0.0339040532, 0.0, 1.77749645),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "letter[3]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.01152,
        "pos": (0.262310305, 0.0, 1.7823597),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "letter[4]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.01152,
        "pos": (-0.374147746, 0.0, 1.48354882),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "letter[5]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.01152,
        "pos": (-0.148005528, 0.0, 1.47732404),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "letter[6]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.01152,
        "pos": (0.123786678, 0.0, 1.47807579),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "letter[7]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.01152,
        "pos": (0.381768438, 0.0, 1.49878647),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "letter[8]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.01152,
        "pos": (-0.128646724, 0.0, 1.19712999),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "letter[9]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.01152,
        "pos": (0.109984087, 0.0, 1.19738751),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "letter[10]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.01152,
        "pos": (-0.368659171, 0.0, 0.91437685),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "letter[11]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.01152,
        "pos": (-0.13208816, 0.0, 0.914314696),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "letter[12]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.01152,
        "pos": (0.0989153786, 0.0, 0.906085326),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "letter[13]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.01152,
        "pos": (0.322407632, 0.0, 0.913708148),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "letter[14]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.01152,
        "pos": (-0.340938184, 0.0, 0.624607267),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "letter[15]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.01152,
        "pos": (-0.115466296, 0.0, 0.63080838),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "letter[16]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.01152,
        "pos": (0.112795526, 0.0, 0.632856738),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "letter[17]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.01152,
        "pos": (0.344435083, 0.0, 0.623177085),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
}

# What bodies of particles weigh [kg].
MASSES = {
    "letter[0]": 0.62170858,
    "letter[1]": 0.337652679,
    "letter[2]": 0.582021959,
    "letter[3]": 0.735574229,
    "letter[4]": 0.795324537,
    "letter[5]": 0.799615928,
    "letter[6]": 0.848837768,
    "letter[7]": 0.694243223,
    "letter[8]": 0.727964991,
    "letter[9]": 0.59768613,
    "letter[10]": 0.723526051,
    "letter[11]": 0.784197558,
    "letter[12]": 0.603583232,
    "letter[13]": 0.546953382,
    "letter[14]": 0.53682633,
    "letter[15]": 0.470956336,
    "letter[16]": 0.665117256,
    "letter[17]": 0.807890555,
}


def add_letter(scene):
    """Add 18 copies of letter."""
    copies = [
        # file, pos, color
        ("models/letter.obj", (-0.284883674, 0.0, 1.77888384), (0.8627, 0.0784, 0.2353, 1.0)),
        ("models/letter_a0bf5a9e.obj", (-0.13141302, 0.0, 1.78222074), (1.0, 0.549, 0.0, 1.0)),
        ("models/letter_37a8fbaf.obj", (0.0339040532, 0.0, 1.77749645), (1.0, 0.8431, 0.0, 1.0)),
        ("models/letter_4f0d5863.obj", (0.262310305, 0.0, 1.7823597), (0.1804, 0.5451, 0.3412, 1.0)),
        ("models/letter_b115283c.obj", (-0.374147746, 0.0, 1.48354882), (0.2549, 0.4118, 0.8824, 1.0)),
        ("models/letter_2da17146.obj", (-0.148005528, 0.0, 1.47732404), (0.502, 0.0, 0.502, 1.0)),
        ("models/letter_85edfe97.obj", (0.123786678, 0.0, 1.47807579), (1.0, 0.4118, 0.7059, 1.0)),
        ("models/letter_4fc8fce6.obj", (0.381768438, 0.0, 1.49878647), (0.8627, 0.0784, 0.2353, 1.0)),
        ("models/letter_428d416e.obj", (-0.128646724, 0.0, 1.19712999), (1.0, 0.549, 0.0, 1.0)),
        ("models/letter_d0b1dc9d.obj", (0.109984087, 0.0, 1.19738751), (1.0, 0.8431, 0.0, 1.0)),
        ("models/letter_da1428a4.obj", (-0.368659171, 0.0, 0.91437685), (0.1804, 0.5451, 0.3412, 1.0)),
        ("models/letter_db8ab9b9.obj", (-0.13208816, 0.0, 0.914314696), (0.2549, 0.4118, 0.8824, 1.0)),
        ("models/letter_a955f24b.obj", (0.0989153786, 0.0, 0.906085326), (0.502, 0.0, 0.502, 1.0)),
        ("models/letter_e62723f6.obj", (0.322407632, 0.0, 0.913708148), (1.0, 0.4118, 0.7059, 1.0)),
        ("models/letter_d15477db.obj", (-0.340938184, 0.0, 0.624607267), (0.8627, 0.0784, 0.2353, 1.0)),
        ("models/letter_76a58fc3.obj", (-0.115466296, 0.0, 0.63080838), (1.0, 0.549, 0.0, 1.0)),
        ("models/letter_14d5134d.obj", (0.112795526, 0.0, 0.632856738), (1.0, 0.8431, 0.0, 1.0)),
        ("models/letter_ecb0cc61.obj", (0.344435083, 0.0, 0.623177085), (0.1804, 0.5451, 0.3412, 1.0)),
    ]
    return {
        # case.yaml:19
        f"letter[{i}]": scene.add_entity(
            gs.morphs.Mesh(
                file=str(HERE / file),
                pos=pos,
            ),
            material=gs.materials.MPM.Elastic(E=600000.0, nu=0.3, rho=500.0, model="corotation"),
            surface=gs.surfaces.Default(color=color, roughness=0.9, metallic=0.0, vis_mode="particle"),
            name=f"letter[{i}]",
        )
        for i, (file, pos, color) in enumerate(copies)
    }


def add_bodies(scene):
    """Add everything that moves; return the entities by name."""
    bodies = {
        **add_letter(scene),
    }
    weigh(bodies, MASSES)
    return bodies


def configure(bodies):
    """Set what can be set only after the scene is built."""

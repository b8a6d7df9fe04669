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
        "spacing": 0.01408,
        "pos": (-0.284883674, 0.0, 1.62888384),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "letter[1]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.01408,
        "pos": (-0.13141302, 0.0, 1.63222074),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "letter[2]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.01408,
        "pos": (0.0339040532, 0.0, 1.62749645),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "letter[3]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.01408,
        "pos": (0.262310305, 0.0, 1.6323597),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "letter[4]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.01408,
        "pos": (-0.374147746, 0.0, 1.33354882),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "letter[5]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.01408,
        "pos": (-0.148005528, 0.0, 1.32732404),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "letter[6]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.01408,
        "pos": (0.123786678, 0.0, 1.32807579),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "letter[7]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.01408,
        "pos": (0.381768438, 0.0, 1.34878647),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "letter[8]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.01408,
        "pos": (-0.128646724, 0.0, 1.04712999),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "letter[9]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.01408,
        "pos": (0.109984087, 0.0, 1.04738751),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "letter[10]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.01408,
        "pos": (-0.368659171, 0.0, 0.76437685),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "letter[11]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.01408,
        "pos": (-0.13208816, 0.0, 0.764314696),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "letter[12]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.01408,
        "pos": (0.0989153786, 0.0, 0.756085326),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "letter[13]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.01408,
        "pos": (0.322407632, 0.0, 0.763708148),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "letter[14]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.01408,
        "pos": (-0.340938184, 0.0, 0.474607267),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "letter[15]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.01408,
        "pos": (-0.115466296, 0.0, 0.48080838),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "letter[16]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.01408,
        "pos": (0.112795526, 0.0, 0.482856738),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "letter[17]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.01408,
        "pos": (0.344435083, 0.0, 0.473177085),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
}

# What bodies of particles weigh [kg].
MASSES = {
    "letter[0]": 0.777135725,
    "letter[1]": 0.422065849,
    "letter[2]": 0.727527449,
    "letter[3]": 0.919467787,
    "letter[4]": 0.994155671,
    "letter[5]": 0.99951991,
    "letter[6]": 1.06104721,
    "letter[7]": 0.867804028,
    "letter[8]": 0.909956238,
    "letter[9]": 0.747107662,
    "letter[10]": 0.904407564,
    "letter[11]": 0.980246948,
    "letter[12]": 0.754479041,
    "letter[13]": 0.683691727,
    "letter[14]": 0.671032913,
    "letter[15]": 0.58869542,
    "letter[16]": 0.831396571,
    "letter[17]": 1.00986319,
}


def add_letter(scene):
    """Add 18 copies of letter."""
    copies = [
        # file, pos, color
        ("models/letter.obj", (-0.284883674, 0.0, 1.62888384), (0.8196, 0.2863, 0.3569, 1.0)),
        ("models/letter_9467a91d.obj", (-0.13141302, 0.0, 1.63222074), (0.9412, 0.5412, 0.2941, 1.0)),
        ("models/letter_91c2eee6.obj", (0.0339040532, 0.0, 1.62749645), (0.9294, 0.6824, 0.2863, 1.0)),
        ("models/letter_dbec38c6.obj", (0.262310305, 0.0, 1.6323597), (0.2471, 0.6118, 0.4863, 1.0)),
        ("models/letter_bcb89ed9.obj", (-0.374147746, 0.0, 1.33354882), (0.2353, 0.4314, 0.6235, 1.0)),
        ("models/letter_7d497ebe.obj", (-0.148005528, 0.0, 1.32732404), (0.4902, 0.3569, 0.651, 1.0)),
        ("models/letter_091bd458.obj", (0.123786678, 0.0, 1.32807579), (0.898, 0.5608, 0.6902, 1.0)),
        ("models/letter_956ebb9e.obj", (0.381768438, 0.0, 1.34878647), (0.8196, 0.2863, 0.3569, 1.0)),
        ("models/letter_e8f8cee1.obj", (-0.128646724, 0.0, 1.04712999), (0.9412, 0.5412, 0.2941, 1.0)),
        ("models/letter_fb342e9b.obj", (0.109984087, 0.0, 1.04738751), (0.9294, 0.6824, 0.2863, 1.0)),
        ("models/letter_fb34c296.obj", (-0.368659171, 0.0, 0.76437685), (0.2471, 0.6118, 0.4863, 1.0)),
        ("models/letter_84336d2e.obj", (-0.13208816, 0.0, 0.764314696), (0.2353, 0.4314, 0.6235, 1.0)),
        ("models/letter_2fe773fc.obj", (0.0989153786, 0.0, 0.756085326), (0.4902, 0.3569, 0.651, 1.0)),
        ("models/letter_3fea17ea.obj", (0.322407632, 0.0, 0.763708148), (0.898, 0.5608, 0.6902, 1.0)),
        ("models/letter_c36edd00.obj", (-0.340938184, 0.0, 0.474607267), (0.8196, 0.2863, 0.3569, 1.0)),
        ("models/letter_90d3c3e9.obj", (-0.115466296, 0.0, 0.48080838), (0.9412, 0.5412, 0.2941, 1.0)),
        ("models/letter_ffca091c.obj", (0.112795526, 0.0, 0.482856738), (0.9294, 0.6824, 0.2863, 1.0)),
        ("models/letter_3d1ddf7e.obj", (0.344435083, 0.0, 0.473177085), (0.2471, 0.6118, 0.4863, 1.0)),
    ]
    return {
        # case.yaml:19
        f"letter[{i}]": scene.add_entity(
            gs.morphs.Mesh(
                file=str(HERE / file),
                pos=pos,
            ),
            material=gs.materials.MPM.Elastic(E=600000.0, nu=0.3, rho=500.0, model="corotation"),
            surface=gs.surfaces.Default(color=color, roughness=0.5, metallic=0.0, vis_mode="particle"),
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

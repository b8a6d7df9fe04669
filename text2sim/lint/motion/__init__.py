"""Predictions of the motion of bodies, from the case alone.

`whereabouts` predicts one body: its probable position at a time, and a box that it hardly leaves. It uses `flight` for
bodies that fall or are thrown, `reach` for bodies on joints, and `compiler.prescribed` for driven bodies. `causes`
bounds the motion of the scene by a time, and `initial_rest` says whether everything is at rest at the start.
"""

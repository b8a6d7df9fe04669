"""Predictions of where bodies get, from the case alone.

`whereabouts` answers for one body: where it probably is at a time, and a box that it hardly leaves. It asks `flight`
about what falls or is thrown, `reach` about what joints hold, and `compiler.prescribed` about what is driven. `causes`
answers for the scene: how far anything can have got by a time, and `initial_rest` whether everything stands still.
"""

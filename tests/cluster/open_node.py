"""Replacement for `ray_pool._on_node` that can also call functions of these tests."""

from text2sim.cluster import ray_pool, task

REAL = ray_pool._on_node


def on_node(*arguments):
    task.PACKAGE = ""
    return REAL(*arguments)

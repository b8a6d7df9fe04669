"""What Ray runs in place of `ray_pool._on_node`: the same, for functions of these tests, too."""

from text2sim.cluster import ray_pool, task

REAL = ray_pool._on_node


def on_node(*arguments):
    task.PACKAGE = ""
    return REAL(*arguments)

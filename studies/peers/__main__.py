"""Measure snapmap beside its peers, for docs/accuracy.md and docs/validation.md.

./run python -m studies peers [--small]

The tables say of packages of locks/requirements-peers.lock which are not installed.
"""

from ..common import command_device, few
from ..tables import write
from .contenders import contenders
from .measure import alone_table, map_table, measure
from .scene import COSINES, ELEMENTS, ROWS, make_scene
from .structure import structure_table


def main() -> None:
    device = command_device()
    scenes = {name: make_scene(device, name, few(ROWS)) for name in (COSINES, ELEMENTS)}
    measured = measure([*contenders()], scenes)
    speed = map_table(measured), alone_table(measured, scenes)
    write("peers", *speed, structure_table(device))

"""How right the levels of random vibration are, and what a record costs: docs/pulses.md.

PYTHONPATH=workflow/scripts ./run python -m studies.vibration
"""

import time
from pathlib import Path

import numpy as np

import snapmap
from snapmap.io.markdown import number, table

from .few import few
from .random_devices import draw_device

ROOT = Path(__file__).resolve().parents[3]
PSD = [(20.0, 1.0), (80.0, 4.0), (2000.0, 4.0)]
DURATION, REACH = 1.0, 0.5
"""s, and the probability whose level is looked for."""
RECORDS, MANY = 16, 64
QUALITY = 5.0
"""Quality factor of the mass."""
DEVICES, SEED = 6, 3
HEAD = ["device", "level, g rms", "from", "to", f"by {MANY} records", "from", "to", "covered", "s"]


def main():
    named = {"config/damped.yaml": snapmap.load_device(ROOT / "config" / "damped.yaml")}
    draw = np.random.default_rng(SEED)
    named |= {f"random {n}": draw_device(draw) for n in range(1, DEVICES + 1)}
    rows = [[name, *compare(one)] for name, one in few(named).items()]
    print(table(HEAD, rows))
    print(f"covered: {sum(row[-2] == 'yes' for row in rows)} of {len(rows)}")


def compare(device):
    """The level found by few records, and by many others."""
    asked = {"C": [float(np.sqrt(device.spring * device.mass)) / QUALITY]}
    asked |= {"reach": REACH, "duration": DURATION}
    begin = time.perf_counter()
    found = level(device, records=few(RECORDS, 2), **asked)
    took = time.perf_counter() - begin
    seen = level(device, records=few(MANY, 4), seed=SEED, **asked)
    covered = found[1] <= seen[2] and seen[1] <= found[2]
    return [*map(number, (*found, *seen)), "yes" if covered else "no", number(took)]


def level(device, **asked):
    """The level, and its bounds, g rms."""
    found = snapmap.vibration(device, PSD, **asked)
    return [found[key].item() for key in ("level", "level_low", "level_high")]


if __name__ == "__main__":
    main()

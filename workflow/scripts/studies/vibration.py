"""How right the levels of random vibration are, and what a record costs: docs/pulses.md.

PYTHONPATH=workflow/scripts ./run python -m studies.vibration
"""

import time
from pathlib import Path

import numpy as np

import snapmap
from snapmap.device import batch
from snapmap.io.markdown import number, table
from snapmap.solver.adaptive import choose_survey
from snapmap.solver.cells import to_cells
from snapmap.solver.settings import Settings
from snapmap.spectra.psd import Spectrum
from snapmap.spectra.vibration import STEP

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

FACTORS = (1.0, STEP, 4 * STEP)
"""Steps over those of a threshold."""
HEAD_STEPS = ["g rms", "steps", "records that snap", "the same within 20 us", "core s per s"]


def main():
    named = {"config/damped.yaml": snapmap.load_device(ROOT / "config" / "damped.yaml")}
    draw = np.random.default_rng(SEED)
    named |= {f"random {n}": draw_device(draw) for n in range(1, DEVICES + 1)}
    rows = [[name, *compare(one)] for name, one in few(named).items()]
    print(table(HEAD, rows))
    device = named["config/damped.yaml"]
    below = float(rows[0][1]) * np.array(few([0.9, 1.0, 1.1]))
    print(table(HEAD_STEPS, [row for one in below for row in steps(device, one)]))
    print(f"covered: {sum(row[-2] == 'yes' for row in rows)} of {len(rows)}")


def steps(device, at):
    """How many records snap at a level, g rms, in ever longer steps, and what a second costs."""
    spectrum, one = Spectrum(PSD), batch([device])
    drawn = [spectrum.record(1.0, [SEED, n]) for n in range(few(RECORDS, 2))]
    pulses, peaks = zip(*drawn, strict=True)
    N, C = np.array(peaks) * at / spectrum.rms, np.sqrt(device.spring * device.mass) / QUALITY
    cells = to_cells(one, 0, N, 1.0, C, 0.0, np.arange(len(pulses)), pulses)
    asked = Settings(horizon=0.0, until="snap", repeat=False)
    model, shortest, rows = choose_survey(one, {"name": "auto"}).decides, None, []
    for factor in few(FACTORS, 2):
        begin = time.process_time()
        found = model.with_step(factor).follow(cells, asked).t_snap
        took = time.process_time() - begin
        shortest = found if shortest is None else shortest
        same = np.isclose(found, shortest, rtol=0, atol=20.0, equal_nan=True).sum()
        followed = np.fmin(found, 1e6).sum() / 1e6
        seen = np.isfinite(found).sum()
        rows.append([f"{at:.3g}", number(factor), str(seen), str(same), number(took / followed)])
    return rows


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

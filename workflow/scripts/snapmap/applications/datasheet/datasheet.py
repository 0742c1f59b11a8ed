"""Data sheets of devices in Markdown: values with units and errors."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from operator import attrgetter

import numpy as np
import xarray as xr

from ...beam.equilibria import buckling_modes
from ...beam.limit_loads import least_back, static_threshold
from ...beam.modal import natural_frequency
from ...device.device import Beam
from ...device.samples import Tolerances
from ...files.text import DASH, leaves, plain, table
from ...solver.options import section_of
from ...solver.outcome import REPEATED_STEP
from ...study.provenance import code_date, code_version, config_hash
from ...study.shock import Shock
from ...study.study import Study
from ...thresholds.slow import first_obstacle, growth_rate, slow_up_to
from ...values.units import OF_DAMPER
from .. import attached
from ..histories.history import FARTHEST, extremes_of
from ..requirements.verdict import Verdict, at_corner
from ..statics.statics import statics_of
from .parts import OUTSIDE, left_out, of_batch, required_shocks

UNITS = {
    "toward_max": ("travel of the mass towards the beam", "um"),
    "away_max": ("travel of the mass away from the beam", "um"),
    "contact_force_max": ("force between mass and beam, an indicator", "uN"),
    "stress_max": ("tensile stress in the beam", "MPa"),
}
"""Words and unit of each of `Extremes`."""
OF_LAWS = "not known under model.laws"


def datasheet(
    study: Study,
    verdicts: Sequence[Verdict],
    source: Mapping,
    requirements: Sequence[Shock] = (),
    made: xr.Dataset | None = None,
    damper: tuple[str, float] = (OF_DAMPER, 1.0),
    doubts: Sequence[str] = (),
) -> str:
    """Write the data sheets of a study's devices, in Markdown.

    source: the config as the user has it
    made: dataset of `tolerances_of` for these requirements, or None if nothing scatters
    damper: name of the unit of C, and its size in uN us/um
    doubts: lines on values that are hardly meant
    """
    several, sheets = isinstance(study.device, Mapping), []
    unit, size = damper
    written = source.get("devices") or {"device": source["device"]}
    verdicts = [replace(verdict, C=verdict.C / size) for verdict in verdicts]
    made = made if made is None else made.assign_coords(C=made.C / size)
    for name, device in study.devices().items():
        of_device = [verdict for verdict in verdicts if not several or verdict.device == name]
        of_device = sorted(of_device, key=attrgetter("badness"), reverse=True)
        batch = made.sel(device=name) if made is not None and several else made
        heads = ["# Data sheet", source.get("title"), name if several else ""]
        facts = _device(study, device, written[name])
        sheets += [f"{' of '.join(filter(None, heads))}\n", table(["device", "value"], facts)]
        sheets += [table(["config", "value"], _of_config(source))]
        at_rest = f"at rest at {plain(device.temperature)} degC"
        sheets += [table([at_rest, "value"], _at_rest(device, study.model.laws, of_device, damper))]
        sheets += [f"Doubted: {line}.\n" for line in doubts]
        sheets += required_shocks(device, of_device, f"C, {unit}")
        if requirements:
            largest = _largest(replace(study, device=device), requirements, of_device, size)
            largest = table(["what", "value", "error", "under"], largest)
            sheets += ["Largest under these shocks:\n", largest]
        for application in attached().values():
            sheets += application.in_datasheet(study, of_device)
        sheets += of_batch(batch, study.shocks, f"C, {unit}") if batch is not None else []
        sheets += left_out(device)
    blank = table(["checked by", "date", "signature"], [[" ", " ", " "]])
    return "\n".join([*sheets, blank])


def _device(study, device, written):
    """Rows of code, model, support, and the values of the config."""
    name, *options = section_of(study.model).items()
    words = ", ".join(f"{key} {value}" for key, value in options)
    yield ["made by", ", of ".join(filter(None, [f"snapmap {code_version()}", code_date()]))]
    yield ["model", " ".join(filter(None, [name[1], words]))]
    yield ["support", "free to tilt" if device.beam.free else "guided: the beam cannot tilt"]
    for key, text in leaves(written):
        yield [key.replace(".", ": ").replace("_", " "), text]


def _of_config(source):
    """Rows of the config's hash, of its runs and axes, and of what scatters, as it has them."""
    yield ["SHA-256 of its values as sorted JSON", f"{config_hash(source)}..."]
    named = {"pulse": "pulse", "run": "run", "sweep": "sweep", "tolerances": "devices as made"}
    for key, what in named.items():
        for name, value in source.get(key, {}).items():
            is_width = key == "tolerances" and name not in Tolerances._fields
            kind = ", standard deviation" if is_width and not isinstance(value, Mapping) else ""
            yield [f"{what}: {name.replace('_', ' ')}", _written(value) + kind]


def _written(value):
    """Write a value of a config in one line."""
    if isinstance(value, Mapping):
        return ", ".join(f"{key} {_written(part)}" for key, part in value.items())
    if isinstance(value, list | tuple):
        return ", ".join(map(_written, value))
    return str(value)


def _at_rest(device, laws, verdicts, damper):
    """Rows of what is known at rest and of slow shocks; of forces that are laws it is not."""
    rows = dict(_of_beam(device))
    if laws and laws.force:
        rows = dict.fromkeys(rows, OF_LAWS)
    yield from map(list, rows.items())
    if not device.is_alone:
        frequency = f"{1e3 * device.mass_frequency / (2 * np.pi):.5g} kHz"
        yield ["frequency of the mass on its spring", frequency]
    static = static_threshold(device)
    slow = f"{static:.5g}; faster shocks may need less"
    yield ["N above which a slow shock snaps it", OF_LAWS if laws else slow]
    unit, size = damper
    for C in sorted({verdict.C for verdict in verdicts}) if not laws else ():
        dwell = 2 / growth_rate(device, C * size, static)
        text = f"{dwell:.4g} us, for shocks up to N = {slow_up_to(device, static):.5g}"
        if obstacle := first_obstacle(device, static):
            text = f"not known: {obstacle}"
        yield [f"time that the slow shock must stay above it, C = {C:g} {unit}", text]


def _of_beam(device):
    """Pairs of what a beam has without a mass, and its value."""
    path, beam = statics_of(device), device.beam
    force, error = reset_force(beam)
    resets = f"{force:.5g} ± {plain(error, 1)} uN" if force > 0 else "none: it returns by itself"
    yield "force that snaps the beam", f"{path.largest_force.item():.5g} uN"
    yield "force that resets it", resets
    travel = f"{beam.height - beam.second_equilibrium:.5g} um" if beam.is_bistable else DASH
    yield "travel of the midpoint to the second shape", travel
    if "hold_force" in path:
        at = f"force on the electrode at {path.contact_at.item():g} um"
        yield at, f"{path.hold_force.item():.5g} uN"
    yield "first frequency of the beam", f"{1e3 * natural_frequency(beam) / (2 * np.pi):.5g} kHz"


def reset_force(beam: Beam) -> tuple[float, float]:
    """Find the force on the midpoint that leaves a beam no second shape, and its error, uN.

    The force is below 0 if the beam returns by itself. The error is the difference to half as many
    modes.
    """
    modes = buckling_modes(beam)
    modes = modes._replace(load=modes.midpoint)
    kept = slice(len(modes.buckling) // 2)
    half = modes._replace(**{key: getattr(modes, key)[kept] for key in modes._fields[:4]})
    force = least_back(modes)
    return float(force), float(abs(force - least_back(half)))


def _largest(study, requirements, verdicts, size):
    """Rows of `UNITS`: the largest value under all required shocks, its difference to another step
    as its error, and the corner.

    size: of the unit of C in the verdicts, uN us/um
    """
    by_name = {required.name: required for required in requirements}
    shocks = [verdict for verdict in verdicts if verdict.requirement in by_name]
    stops = {"toward_max": study.device.stop_toward, "away_max": study.device.stop_away}
    free = [key for key, stop in stops.items() if np.isinf(stop)]
    for key, (words, unit) in UNITS.items():
        if not np.isfinite([getattr(verdict, key) for verdict in shocks]).any():
            continue
        worst = max(shocks, key=attrgetter(key))
        shock = by_name[worst.requirement]
        under = at_corner(study, shock, worst)
        again = extremes_of(under, shock.N, shock.f0, worst.C * size, step=REPEATED_STEP)
        value, other = getattr(worst, key), getattr(again, key)
        is_outside = key in free and value > FARTHEST * study.device.beam.height
        text = f"{plain(value)} {unit}" + (f"; {OUTSIDE}" if is_outside else "")
        where = f"{worst.requirement}, {worst.corner}"
        yield [words, text, f"{plain(abs(value - other), 1)} {unit}", where]

"""Data sheets of devices in Markdown: values with units and errors, shocks, devices as made."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from math import pi
from operator import attrgetter

import numpy as np
import xarray as xr

from ...beam.equilibria import buckling_modes
from ...beam.limit_loads import least_back, static_threshold
from ...beam.modal import natural_frequency
from ...device.device import Beam, Device
from ...device.samples import Tolerances
from ...files.text import DASH, leaves, plain, table
from ...numerics.portable import evenly
from ...numerics.statistics import percents, scope
from ...pulse.shocks import Shocks
from ...solver.options import section_of
from ...solver.outcome import REPEATED_STEP
from ...study.axes import DIRECTION, SHAPE
from ...study.provenance import code_date, code_version, config_hash
from ...study.shock import Shock
from ...study.study import Study
from ...thresholds.slow import first_obstacle, growth_rate, slow_up_to
from ...values.units import OF_DAMPER
from .. import attached
from ..histories.history import FARTHEST, extremes_of
from ..requirements.summary import LEVELS, missing_fire
from ..requirements.verdict import Verdict, at_corner, must_text
from ..statics.statics import statics_of

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
        sheets += [f"Warning: {line}\n" for line in doubts]
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
    travel = f"{beam.height - beam.second_equilibrium:.5g} um" if force > 0 else DASH
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


OUTSIDE = "outside any package: not valid"
"""Mark of results in which the mass travels beyond FARTHEST rises on a side without a stop."""
PICTURE = "![margins of the requirements](figures/requirements.png)\n"
ERRORS = (
    "± is the error of the calculation alone, for the nominal device: of the search, the time step "
    "and the number of shapes. It has no scatter of devices, and nothing that the model leaves "
    "out.\n"
)
NEVER = "some devices never snap"
LEVELS_SHOWN = 12
"""Most rows of no-fire and all-fire."""


def required_shocks(device: Device, verdicts: Sequence[Verdict], of_C: str) -> list[str]:
    """Write a table of two rows for each requirement: its worst corner, and all its others.

    verdicts: the worst first; of_C: C with its unit
    """
    head = ["requirement", "verdict", "devices as made that meet it", "shock", "at, degC", of_C]
    head += ["required", "threshold", "threshold over required", "the beam"]
    head += ["strength over stress", "breaks"]
    rows = []
    for name in dict.fromkeys(verdict.requirement for verdict in verdicts):
        worst, *others = (verdict for verdict in verdicts if verdict.requirement == name)
        rows.append([must_text(name, worst.must_snap), *_cells([worst])])
        if others:
            rows.append([f"its other cases, {len(others)}", *_cells(others)])
    of_N = f"{plain(device.gravity * 1e6)} m/s^2"
    of_N = f"{device.force:g} uN on the midpoint" if device.force else of_N
    words = f"Required shocks, each by its worst case; amplitudes are multiples of {of_N}.\n"
    return [words, ERRORS, table(head, rows), PICTURE]


def _cells(verdicts):
    """Cells of one corner, or of several: their words, and the ranges of their numbers."""
    first = verdicts[0]
    level = LEVELS.get(first.shape, "")

    def span(key, digits=4, error=""):
        known = [getattr(verdict, key) for verdict in verdicts]
        words = _span(known, digits)
        if error and len(verdicts) == 1 and np.isfinite(known[0]):
            words += f" ± {plain(getattr(first, error), 2)}"
        return words

    def amplitude(key, scale, error=""):
        factor, of = getattr(first, scale), "drop" if first.drop else "record"
        is_told = np.isfinite(factor) and not (first.drop and factor == 1)
        return span(key, 5, error) + level + (f" ({span(scale)} of the {of})" if is_told else "")

    def joined(words):
        return "; ".join(dict.fromkeys(words))

    threshold, never = [], np.isnan([verdict.N_first for verdict in verdicts])
    if not never.all():
        threshold.append(amplitude("N_first", "scale_first", "N_error"))
    if never.any():
        threshold.append("nothing snaps")
    words = [verdict.verdict_text for verdict in verdicts]
    is_outside = any(verdict.travel_over_rise > FARTHEST for verdict in verdicts)
    return [
        joined(words + [OUTSIDE] * is_outside),
        joined(verdict.share_text or DASH for verdict in verdicts),
        joined(verdict.shock for verdict in verdicts),
        span("temperature"),
        span("C"),
        amplitude("N", "scale"),
        " or ".join(threshold),
        span("margin", 4, "margin_error"),
        joined(verdict.end_text for verdict in verdicts),
        span("strength_margin", 3),
        span("break_probability", 3) if np.isfinite(first.strength_margin) else DASH,
    ]


def _span(values: Iterable[float], digits: int) -> str:
    """Write the range of those numbers that are known."""
    known = [value for value in values if np.isfinite(value)]
    if not known:
        return DASH
    return " to ".join(dict.fromkeys(plain(end, digits) for end in (min(known), max(known))))


def of_batch(made: xr.Dataset, shocks: Shocks, of_C: str) -> list[str]:
    """Write tables of no-fire and all-fire, and of the yield.

    made: dataset of one device, as of `tolerances_of`; shocks: of the study
    """
    size, tables = made.sizes["sample"], _levels(made, shocks, of_C)
    if "yield" in made:
        shares = zip(made.C.values, made["yield"].values, made.yield_bound.values.T, strict=True)
        rows = [[f"{C:g}", percents(one), percents(*bounds)] for C, one, bounds in shares]
        words = f"Share of {size} devices as made that meet all{scope(made['yield'])}:\n"
        tables += [words, table([of_C, "share", "bounds at 95 % each"], rows)]
    return tables


def _levels(made, shocks, of_C):
    """Write the table of no-fire and all-fire, or how many devices they take."""
    size, fire, degrees = made.sizes["sample"], made.N_all_fire, plain(made.temperature.item())
    few, ends = missing_fire(fire, size), ("N_no_fire", "N_all_fire")
    words = f"No-fire (at most {percents(1 - fire.share)} snap) and all-fire (at least "
    words += f"{percents(fire.share)} snap) of {size} devices as made at {degrees} degC, "
    words += f"at {plain(100 * fire.confidence)} % confidence"
    if few:
        return [f"{words}: {few}.\n"]
    levels = made[[*ends, "ragged"]].to_dataframe().reset_index()
    kept = levels.iloc[evenly(len(levels), LEVELS_SHOWN)]
    names = {SHAPE: shocks.pulses[0].name, DIRECTION: shocks.directions[0]}
    rows = [
        [
            f"{level[SHAPE]} {level[DIRECTION]}" + (", ragged" if level["ragged"] else ""),
            plain(1e3 / level["f0"]),
            f"{level['C']:g}",
            *(plain(level[key]) if np.isfinite(level[key]) else NEVER for key in ends),
        ]
        for level in (names | row for row in kept.to_dict("records"))
    ]
    part = f" ({len(kept)} of {len(levels)} pulses)" if len(kept) < len(levels) else ""
    head = ["pulse", "duration, ms", of_C, "no-fire", "all-fire"]
    return [f"{words}{part}:\n", table(head, rows)]


def left_out(device: Device) -> list[str]:
    """Write what the model leaves out, with the change of the threshold."""
    beam, example = device.beam, "measured on the example of the documents, 1500 Hz"
    slope, shear = pi * beam.rise / beam.span, 2 * pi * beam.thickness / beam.span
    rows = [
        ["anchors that turn", "-1.5 %", example],
        ["gas that is squeezed: C from 0.025 to 200 uN us/um", "-0.7 to +6.3 %", example],
        ["an equal shock before", "-4.1 %", example],
        ["resonance of the package", "to -41 %", "an oscillator"],
        ["slope of the beam", f"some {plain(100 * slope**2, 1)} %", "(pi rise/span)^2"],
        ["shear in the beam", f"some {plain(100 * shear**2, 1)} %", "(2 pi thickness/span)^2"],
        ["rotation of the mass, other directions, friction, adhesion", "not known", DASH],
        ["thresholds measured on devices", "not compared", "calibration compares them"],
    ]
    if not device.is_alone:
        lost = 50 * beam.weight / (device.mass + beam.weight)
        rows.append(["an inelastic impact", f"to +{plain(lost, 1)} %", "half of m/(M + m)"])
    return ["What the model leaves out:\n", table(["cause", "threshold", "by"], rows)]

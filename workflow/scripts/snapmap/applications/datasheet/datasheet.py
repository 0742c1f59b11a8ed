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
from ...numerics.statistics import percents, scope
from ...solver.options import section_of
from ...solver.outcome import REPEATED_STEP
from ...study.provenance import code_date, code_version, config_hash
from ...study.shock import Shock
from ...study.study import Study
from ...thresholds.slow import growth_rate
from ...values.units import OF_DAMPER
from .. import attached
from ..histories.history import FARTHEST, extremes_of
from ..requirements.summary import LEVELS
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
OUTSIDE = "outside any package: not valid"
"""Mark of results in which the mass travels beyond FARTHEST rises on a side without a stop."""
PICTURE = "![margins of the requirements](figures/requirements.png)\n"


def datasheet(
    study: Study,
    verdicts: Sequence[Verdict],
    source: Mapping,
    requirements: Sequence[Shock] = (),
    made: xr.Dataset | None = None,
    damper: tuple[str, float] = (OF_DAMPER, 1.0),
) -> str:
    """Write the data sheets of a study's devices, in Markdown.

    source: the config as the user has it
    made: dataset of `tolerances_of` for these requirements, or None if nothing scatters
    damper: name of the unit of C, and its size in uN us/um
    """
    several, sheets = isinstance(study.device, Mapping), []
    unit, size = damper
    of_C = f"C, {unit}"
    head = ["requirement", "shock", "at, degC", of_C, "required", "threshold"]
    head += ["of devices as made", "threshold over required", "the beam", "verdict"]
    head += ["strength over stress", "breaks"]
    written = source.get("devices") or {"device": source["device"]}
    verdicts = [replace(verdict, C=verdict.C / size) for verdict in verdicts]
    made = made if made is None else made.assign_coords(C=made.C / size)
    for name, device in study.devices().items():
        of_device = [verdict for verdict in verdicts if not several or verdict.device == name]
        batch = made.sel(device=name) if made is not None and several else made
        rows = sorted(of_device, key=lambda verdict: verdict.badness, reverse=True)
        names = [*dict.fromkeys(verdict.requirement for verdict in rows)]
        rows.sort(key=lambda verdict: names.index(verdict.requirement))
        heading = " of ".join(
            filter(None, ["# Data sheet", source.get("title"), name if several else ""])
        )
        facts = _device(study, device, written[name])
        sheets += [f"{heading}\n", table(["device", "value"], facts)]
        sheets += [table(["config", "value"], _of_config(source))]
        at_rest = f"at rest at {plain(device.temperature)} degC"
        sheets += [table([at_rest, "value"], _at_rest(device, study.model.laws, of_device, damper))]
        of_N = f"{plain(device.gravity * 1e6)} m/s^2"
        of_N = f"{device.force:g} uN on the midpoint" if device.force else of_N
        words = f"Required shocks, worst first; amplitudes are multiples of {of_N}:\n"
        sheets += [words, table(head, (_cells(verdict, batch) for verdict in rows)), PICTURE]
        if requirements:
            largest = _largest(replace(study, device=device), requirements, of_device, size)
            largest = table(["what", "value", "error", "under"], largest)
            sheets += ["Largest under these shocks:\n", largest]
        for application in attached().values():
            sheets += application.in_datasheet(study, rows)
        if batch is not None and "yield" in batch:
            words = f"Share of {batch.sizes['sample']} devices as made, with bounds at 95 %:\n"
            sheets += [words, table(["share", of_C, "value", "bounds"], _shares(batch))]
    return "\n".join(sheets)


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
    slow = f"{static_threshold(device):.5g}; faster shocks may need less"
    yield ["N above which a slow shock snaps it", OF_LAWS if laws else slow]
    unit, size = damper
    for C in sorted({verdict.C for verdict in verdicts}) if not laws else ():
        dwell = 2 / growth_rate(device, C * size)
        unknown = "not known: the law of slow shocks does not hold here"
        text = f"{dwell:.4g} us, to first order" if np.isfinite(dwell) else unknown
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


def _cells(verdict, made):
    """Cells of a verdict, with the scatter of thresholds of devices as made."""
    name, spread = verdict.requirement, DASH
    if made is not None and name in made.get("requirement", ()):
        first = made.N_first_required.sel(requirement=name).sel(C=verdict.C, method="nearest")
        share = (first.std(ddof=1) / first.mean()).item()
        if share > 0:
            error = share / np.sqrt(2 * first.count().item())  # of normally distributed thresholds
            spread = f"± {plain(100 * share, 2)} % (± {plain(100 * error, 1)} %)"
    level, threshold, margin = LEVELS.get(verdict.shape, ""), "nothing snaps", DASH
    required = plain(verdict.N, 5) + level
    if np.isfinite(verdict.scale):
        required += f" ({plain(verdict.scale)} of the record)"
    if np.isfinite(verdict.N_first):
        threshold = f"{verdict.N_first:.5g} ± {plain(verdict.N_error, 2)}"
        threshold += level
        if np.isfinite(verdict.scale_first):
            threshold += f" ({plain(verdict.scale_first)} of the record)"
        margin = f"{plain(verdict.margin)} ± {plain(verdict.margin_error, 1)}"
    breaks = [DASH, DASH]
    if np.isfinite(verdict.strength_margin):
        values = verdict.strength_margin, verdict.break_probability
        breaks = [plain(value, 3) if np.isfinite(value) else DASH for value in values]
    return [
        must_text(name, verdict.must_snap),
        verdict.shock,
        plain(verdict.temperature),
        f"{verdict.C:g}",
        required,
        threshold,
        spread,
        margin,
        verdict.end_text,
        verdict.verdict + (f"; {OUTSIDE}" if verdict.travel_over_rise > FARTHEST else ""),
        *breaks,
    ]


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


def _shares(made):
    """Rows of the shares of devices as made that meet all, and that break, at each C."""
    words = {"yield": f"meet all{scope(made['yield'])}", "share_breaking": "break under"}
    for key in filter(made.data_vars.__contains__, words):
        for place in np.ndindex(made[key].shape):
            at = made[[key, f"{key}_bound"]].isel(dict(zip(made[key].dims, place, strict=True)))
            under = [at.requirement.item()] if "requirement" in at.coords else []
            bounds = percents(*at[f"{key}_bound"].values)
            yield [" ".join([words[key], *under]), f"{at.C.item():g}", percents(at[key]), bounds]

"""The verdict on a requirement: a record, its words, and the table of all verdicts of a study."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from operator import attrgetter
from pathlib import Path

import numpy as np

from ...files.tables import read_rows, write_table
from ...files.text import plain
from ...numerics.statistics import percents
from ...solver.settings import FIRST, SECOND
from ...study.shock import Shock
from ...study.study import ANY, SNAPS, Study
from ...values.units import spelling

MET, VIOLATED, UNCLEAR = "met", "failed", "unclear"
STAYS, RETURNS, OPEN, DIFFERS = "stays", "arrives and returns", "still swings", "ends differ"
NO_ARRIVAL, NOT_FOLLOWED = "does not arrive", "not followed"
"""How a beam ends after a required shock."""
LONG = 1e4
"""Least duration that is told in seconds, ms."""
NEEDS = {0: "must not trip", 1: "must trip and stay", 2: "may trip", 3: "must arrive"}
"""What a device must do, by the codes of SNAPS."""
UNITS = {"f0": "Hz", "duration": "ms", "temperature": "degC"}
UNITS |= {"toward_max": "um", "away_max": "um", "contact_force_max": "uN"}
UNITS |= dict.fromkeys(("stress_max", "stress_max_to_snap"), "MPa")
"""Units of requirements.csv, by column; C has that of the study."""


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """The verdict on a requirement for one device, C, temperature, and shape and direction.

    Numbers are NaN where they are not known.

    N, N_first, N_error: multiples of g; f0: Hz; duration: ms; C: uN us/um; temperature: degC
    must_snap: true (it must arrive and stay), false, ARRIVES, or ANY
    outcome: outcome of the required shock, simulated
    margin, margin_error: N_first and its error bar over N; NaN where nothing snaps
    verdict: MET, VIOLATED, or UNCLEAR if N is within the error bar
    scale, scale_first: N and N_first as factors of a recorded shock
    drop: height, shape, duration and rebounds in words; empty for other shocks
    start: as in `Run`
    end: how the required shock ends, in the runs near N that arrive: STAYS if all stay, DIFFERS if
        some do, else RETURNS or OPEN; NO_ARRIVAL at N itself, or NOT_FOLLOWED
    share_staying: share of these runs that stay in the other shape
    toward_max to stress_max_to_snap: as in `Extremes`; travel_over_rise: `free_travel`
    must_survive: least probability that it must not break; 0 if it may break
    strength_margin: strength over the largest stress; of a Weibull distribution the strength at
        which 63 % break
    break_probability: probability that it breaks; 0 or 1 if the strength is a number
    share, share_low, share_high: share of devices as made that meet the requirement at this C, and
        its bounds; share_asked: least share, which then decides the verdict
    devices: number of devices as made that would decide it, if it is UNCLEAR for their share
    more: what a requirement of another kind adds, by name
    """

    requirement: str
    device: str
    shape: str
    direction: str
    N: float
    f0: float
    duration: float
    C: float
    temperature: float
    must_snap: bool | str
    outcome: str
    N_first: float
    N_error: float
    margin: float
    margin_error: float
    verdict: str
    scale: float = np.nan
    scale_first: float = np.nan
    drop: str = ""
    start: str = FIRST
    end: str = NOT_FOLLOWED
    share_staying: float = np.nan
    toward_max: float = np.nan
    away_max: float = np.nan
    contact_force_max: float = np.nan
    stress_max: float = np.nan
    stress_max_to_snap: float = np.nan
    travel_over_rise: float = np.nan
    must_survive: float = np.nan
    strength_margin: float = np.nan
    break_probability: float = np.nan
    share: float = np.nan
    share_low: float = np.nan
    share_high: float = np.nan
    share_asked: float = np.nan
    devices: float = np.nan
    more: Mapping[str, float] = field(default_factory=dict)

    @property
    def breaks(self) -> bool:
        """Whether the beam breaks more probably than it may."""
        return self.break_probability > 1 - self.must_survive

    @property
    def badness(self) -> tuple[int, float, float]:
        """Rank of the verdict, higher if worse: by the word, then by `beyond`.

        A beam that must stay is worse, the fewer of its runs do. Where a trip does not matter, the
        least of the other margins counts.
        """
        severity = (MET, UNCLEAR, VIOLATED).index(self.verdict)
        straying = np.nan_to_num(1 - self.share_staying) if self.must_snap is True else 0.0
        if self.must_snap == ANY:
            margins = [self.more[key] for key in self.more if key.endswith("_margin")]
            margins.append(self.strength_margin if self.must_survive > 0 else np.nan)
            reserve = np.fmin.reduce([np.nan, *margins])
            return severity, straying, -np.inf if np.isnan(reserve) else -reserve
        return severity, straying, self.beyond

    @property
    def beyond(self) -> float:
        """Logarithm of how far the margin is on the wrong side; below 0 on the right side."""
        size = np.inf if np.isnan(self.margin) else np.log(self.margin)
        return size if self.must_snap else -size

    @property
    def shock(self) -> str:
        """The shock in words: shape, direction, duration, and the shape in which it begins."""
        start = ", from the second shape" if self.start == SECOND else ""
        if self.drop:
            return f"{self.drop}, {self.direction}{start}"
        size, unit = (1e3, "s") if self.duration >= LONG else (1.0, "ms")
        lasts = f", {plain(self.duration / size)} {unit}" if np.isfinite(self.duration) else ""
        return f"{self.shape} {self.direction}{lasts}{start}"

    @property
    def corner(self) -> str:
        """Device, shock, C and temperature in words."""
        where = f"{self.shock}, C = {plain(self.C)}, {plain(self.temperature)} degC"
        return ", ".join(filter(None, [self.device, where]))

    @property
    def verdict_text(self) -> str:
        """The verdict, and of whom if values scatter but no share is asked for."""
        return self.verdict + (" by the nominal device" if self.is_nominal else "")

    @property
    def is_nominal(self) -> bool:
        """Whether values scatter, but the verdict is that of the nominal device."""
        return np.isfinite(self.share) and np.isnan(self.share_asked)

    @property
    def share_text(self) -> str:
        """The share of devices as made that meet it, in words; "" if it is not known."""
        if np.isnan(self.share):
            return ""
        words = f"{percents(self.share)} ({percents(self.share_low, self.share_high)})"
        if np.isfinite(self.share_asked):
            words += f", asked {plain(100 * self.share_asked, 7)} %"
        if np.isfinite(self.devices):
            words += f", {self.devices:.0f} devices would decide"
        return words

    @property
    def end_text(self) -> str:
        """How the beam ends after the shock, in words."""
        staying = f", {100 * self.share_staying:.0f} % of the runs stay"
        return self.end + (staying if self.end == DIFFERS else "")


def must_text(name: str, must_snap: bool | int | str) -> str:
    """Write a requirement's name and what the device must do.

    must_snap: as in verdicts, or as coded in datasets
    """
    return f"{name}, {NEEDS[SNAPS[must_snap] if isinstance(must_snap, str) else must_snap]}"


def write_verdicts(verdicts: Iterable[Verdict], path: str | Path, unit_of_C: str) -> None:
    """Write requirements.csv, a row for each verdict; what is not known stays empty.

    unit_of_C: as a config spells it
    """
    import pandas  # imported late: most runs have no table

    rows = pandas.DataFrame([{**vars(verdict), **verdict.more} for verdict in verdicts])
    places = "N", "f0", "duration", "C", "temperature"
    write_table(rows.drop(columns="more"), path, UNITS | {"C": spelling(unit_of_C).files}, places)


def read_verdicts(path: str | Path) -> list[Verdict]:
    """Read requirements.csv."""
    return [_read_verdict(row) for row in read_rows(path)]


def _read_verdict(row):
    kinds = {each.name: each.type for each in fields(Verdict)}
    words = {name: word for name, word in row.items() if kinds.get(name) is str}
    must = {"True": True, "False": False}.get(row["must_snap"], row["must_snap"])
    others = row.keys() - words.keys() - {"must_snap"}
    numbers = {name: float(row[name] or "nan") for name in row if name in others}
    more = {name: numbers.pop(name) for name in [*numbers] if name not in kinds}
    return Verdict(**words, **numbers, must_snap=must, more=more)


def corners(verdicts: Sequence[Verdict]) -> list[list[Verdict]]:
    """Group verdicts by requirement, device and C; each group begins with its worst."""
    groups: dict[tuple, list[Verdict]] = {}
    for verdict in verdicts:
        groups.setdefault((verdict.requirement, verdict.device, verdict.C), []).append(verdict)
    return [sorted(group, key=attrgetter("badness"), reverse=True) for group in groups.values()]


def each_device(study: Study, temperatures: Sequence[float] = ()) -> Iterator[tuple[str, Study]]:
    """Yield the name and the study of each device at each temperature.

    The name of a single device is empty. Without temperatures each device keeps its own.
    """
    several = isinstance(study.device, Mapping)
    for name, device in study.devices().items():
        for tempered in [device.at(degrees) for degrees in temperatures] or [device]:
            yield name if several else "", replace(study, device=tempered)


def at_corner(study: Study, required: Shock, corner: Verdict) -> Study:
    """Narrow a study to a requirement at the device, temperature, shape and direction of one."""
    device = study.device
    device = device[corner.device] if isinstance(device, Mapping) else device
    if corner.temperature != device.temperature:
        device = device.at(corner.temperature)
    study = required.shaken(study)
    pushed = corner.shape, corner.direction
    for shocks in study.shocks.each():
        if (shocks.pulse.name, shocks.direction) == pushed:
            return replace(study, device=device).under(shocks)
    raise KeyError(pushed)

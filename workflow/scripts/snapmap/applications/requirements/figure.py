"""The safety factor of each required shock."""

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from ...figures import captions, style
from ...figures.scales import number, tick, value_text
from ...study.study import ARRIVES
from ...values.units import OF_DAMPER, spelling
from .verdict import Verdict, corners, must_text

VERDICTS = {
    "met": {"color": "black", "marker": "o"},
    "unclear": {"color": "0.5", "marker": "s"},
    "failed": {"color": style.VERMILION, "marker": "X"},
}
OTHER = {"color": "black", "marker": ".", "linestyle": "", "markersize": 3}
"""Corners that are not the worst."""
WRONG = {"color": "#fdebdc", "linewidth": 0, "label": "threshold on the wrong side"}
"""Where a requirement fails, in all figures."""
BEYOND = 1.25
"""Room beyond the outermost margins, as a factor."""
WIDE = 34
"""Signs in a line of the words beside a row."""


def draw_margins(ax: Axes, verdicts: Sequence[Verdict], unit_of_C: str = OF_DAMPER) -> Axes:
    """Draw the safety factor on N of each verdict, with its error bar; logarithmic.

    unit_of_C: as a config spells it
    Each requirement, device and C has a row, the one with the least slack on top. A marker and the
    words beside it show its worst corner, and where it must trip how the beam ends; dots show the
    others. The factor is the threshold over the required N, or the inverse where the shock must
    trip: above 1 the threshold is where it should be. The words have the share of devices as made
    that meet it.
    """
    groups = sorted(corners(verdicts), key=lambda group: group[0].badness, reverse=True)
    known = [factor for factor in map(_factor, verdicts) if factor == factor]
    low, high = min([*known, 0.8]) / BEYOND, max([*known, 1.25]) * BEYOND
    ax.set(xscale="log", xlim=(low, high), ylim=(len(groups) - 0.5, -0.5))
    ax.axvspan(low, 1, **WRONG)
    for place, (worst, *others) in enumerate(groups):
        margin, *of_others = (_factor(each) for each in (worst, *others))
        ax.plot(of_others, [place] * len(others), **OTHER)
        if margin == margin:
            error = margin * worst.margin_error / worst.margin
            ax.errorbar(margin, place, xerr=error, **_look(worst))
        else:  # the threshold is beyond all
            edge = low if worst.must_snap in (True, ARRIVES) else high
            ax.plot(edge, place, clip_on=False, **_look(worst))
        words = [] if margin == margin else ["snaps at no $N$ seen"]
        if worst.must_snap in (True, ARRIVES):
            words.append(worst.end_text)
        if worst.breaks:
            words.append("the beam breaks")
        if worst.share_text:
            words.append(f"met by {worst.share_text}")
        style.annotate_row(ax, place, captions.fill(", ".join(words).split(", "), WIDE))
    ax.axvline(1, color="black", linewidth=0.6)
    unit = spelling(unit_of_C).figures
    ax.set_yticks(range(len(groups)), [_name(worst, unit) for worst, *_ in groups])
    ax.tick_params(axis="y", which="minor", left=False)
    ax.set_xlabel("safety factor on $N$")
    tick(ax.xaxis, low, high)
    looks = {worst.verdict_text: _look(worst) for worst, *_ in groups}
    keys = [Line2D([], [], linestyle="", **look, label=words) for words, look in looks.items()]
    if len(groups) < len(verdicts):
        keys.append(Line2D([], [], **OTHER, label="another shock or temperature"))
    style.legend(ax, [*keys, Patch(**WRONG)])
    return ax


def _look(verdict):
    """Give the look of a verdict, hollow if it is that of the nominal device alone."""
    return VERDICTS[verdict.verdict] | ({"markerfacecolor": "white"} if verdict.is_nominal else {})


def _factor(verdict):
    """Give the safety factor of a verdict; of a shock that may trip or not, its margin."""
    return 1 / verdict.margin if verdict.must_snap in (True, ARRIVES) else verdict.margin


def _name(verdict, unit):
    shock = f"{verdict.shock.replace('-z', '−z')}, {number(verdict.temperature)} °C"
    shock = shock.replace(f"{verdict.drop}, ", f"{verdict.drop},\n") if verdict.drop else shock
    where = [verdict.device, shock, value_text("C", verdict.C, unit)]
    name = required_text(verdict.requirement, verdict.must_snap)
    return f"{name}\n{', '.join(filter(None, where))}"


def required_text(name: str, must_snap: bool | int | str) -> str:
    """Write a requirement's name and what the device must do, for a figure."""
    return must_text(captions.literal(name), must_snap)

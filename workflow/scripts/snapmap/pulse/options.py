"""What may be written of a pulse, from Python as in a config."""

from collections.abc import Mapping, Sequence

from ..device.argument import Argument, as_plain, integer, number, word
from ..files.text import show
from .pulse import SHAPES, SHARES, TENTH

ANY = number("(-inf, inf)")
SHARE = number("(0, 1)", "", "0.95")
OF_PULSE = {
    "shape": word(*SHAPES),
    "N": Argument(
        "a number above or below 0", lambda value: ANY.fits(value) and value != 0, as_plain
    ),
    **{f"{key}": number("(0, inf)", "us", "500") for key in ("duration", "wait")},
    "height": number("(0, inf)", "um", "1e6"),
    "rebound": number("[0, 0.99]", "", "0.5"),
    **dict.fromkeys(("rise", "fall"), SHARE),
    "repeat": integer(1),
}
"""What each key of a pulse may hold."""


def take_pulse(
    path: str, section: Mapping, needed: Sequence[str], others: Sequence[str] = ()
) -> dict[str, object]:
    """Convert a mapping of these keys to what a pulse may have; else ValueError, one line."""
    if not isinstance(section, Mapping) or not {*needed} <= {*section} <= {*needed, *others}:
        more = f"; it may have {', '.join(others)}" if others else ""
        raise ValueError(f"{path}: {show(section)} is not a mapping of {', '.join(needed)}{more}")
    taken = {key: OF_PULSE[key].take(f"{path}.{key}", value) for key, value in section.items()}
    shares = {key: taken[key] for key in SHARES if key in taken}
    if shares and taken.get("shape") != "trapezoid":
        raise ValueError(f"{path}.{next(iter(shares))}: is of a trapezoid alone; leave it out")
    if sum({"rise": TENTH, "fall": TENTH, **shares}.values()) > 1:
        raise ValueError(f"{path}.rise: with fall is more than the duration; write smaller shares")
    return taken

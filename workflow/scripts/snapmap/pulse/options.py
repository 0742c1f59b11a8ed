"""The keys of a pulse and their values, in Python as in a config."""

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
    **dict.fromkeys(("duration", "wait"), number("(0, inf)", "us", "500")),
    "height": number("(0, inf)", "um", "1e6"),
    "rebound": number("[0, 0.99]", "", "0.5"),
    **dict.fromkeys(("rise", "fall"), SHARE),
    "repeat": integer(1),
}
"""Description of the value of each key."""


def take_pulse(
    path: str, section: Mapping, needed: Sequence[str], others: Sequence[str] = ()
) -> dict[str, object]:
    """Convert a mapping, at a path of a config, of these keys; raises ValueError, one line."""
    if not isinstance(section, Mapping) or not {*needed} <= {*section} <= {*needed, *others}:
        more = f"; it may have {', '.join(others)}" if others else ""
        raise ValueError(f"{path}: {show(section)} is not a mapping of {', '.join(needed)}{more}")
    values = {key: OF_PULSE[key].take(f"{path}.{key}", value) for key, value in section.items()}
    shares = {key: values[key] for key in SHARES if key in values}
    if shares and values.get("shape") != "trapezoid":
        raise ValueError(f"{path}.{next(iter(shares))}: is of a trapezoid alone; leave it out")
    if sum({"rise": TENTH, "fall": TENTH, **shares}.values()) > 1:
        raise ValueError(f"{path}.rise: with fall is more than the duration; write smaller shares")
    return values

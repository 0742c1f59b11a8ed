"""What the files of results say of themselves and, by variables.csv, of each variable."""

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from .provenance import provenance

TITLES = {
    "cube": (
        "Snap-through of a bistable beam under shock",
        "Outcome of each cell of a grid over damping, frequency and amplitude of the shock",
    ),
    "threshold": (
        "Thresholds of snap-through under shock",
        "Amplitudes where snapping begins and is certain, over damping and frequency",
    ),
    "tolerance": (
        "Thresholds of devices as made",
        "Share of devices that snap over damping, frequency and amplitude of the shock",
    ),
    "calibration": (
        "A device read off its shots",
        "Values of a device, their intervals and the residuals of shots, tripped or not",
    ),
    "history": (
        "Time history of one cell",
        "Motion, forces and energies of beam and mass under one shock",
    ),
    "vibration": (
        "Snaps under random vibration",
        "How often stationary Gaussian vibration trips a device, and at which level",
    ),
    "spectrum": (
        "Snaps under records of a shock response spectrum",
        "Which records that meet a spectrum trip a device, and at which factors of it",
    ),
}
"""Title and summary of each product."""


def headed(product: str, document: Mapping) -> dict[str, str]:
    """Attributes of a product: conventions, title, summary and where it is from."""
    title, summary = TITLES[product]
    head = {"Conventions": "CF-1.11, ACDD-1.3", "title": title, "summary": summary}
    return head | provenance(document)


def variables(product: str) -> dict[str, dict]:
    """CF attributes of each variable of a product, by name."""
    with open(Path(__file__).with_suffix(".csv"), encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row.pop("product") == product]
    named = {row.pop("name"): row for row in rows}
    return {name: _attributes(**row) for name, row in named.items()}


def flags(words: Sequence[str]) -> dict:
    """CF attributes of a variable that counts words, from 0."""
    return {
        "flag_values": np.arange(len(words), dtype=np.int8),
        "flag_meanings": " ".join(words),
    }


def _attributes(flag_meanings, **texts):
    given = {key: text for key, text in texts.items() if text}
    return given | (flags(flag_meanings.split()) if flag_meanings else {})

"""The whole config: sections of the core and of all applications, and what they ask of a study."""

from collections.abc import Mapping
from dataclasses import replace

from ..config.document import Core
from ..config.doubts import doubts_of_core
from ..config.study import Caught, Config, convert, unit_of_C
from ..files.named import hold_to_plan
from ..values.records import read, row_of_kinds
from . import attached, gather, merge

Document = row_of_kinds("Document", gather(lambda part: part.section()), Core)
"""The whole config: sections of the core and of all applications."""


def load_config(document: Mapping) -> Config:
    """Check a whole config document and convert it; Faults have a line for each fault."""
    parts = read(Document, document, unit_of_C=unit_of_C(document))
    study, faults = convert(parts, document), Caught()
    requests: dict = {}
    for name, application in attached().items():
        asked = replace(study, requests=requests)
        arguments = getattr(parts, name, None), asked, parts
        requests = {**requests, name: faults.catch((name,), application.request, *arguments)}
    faults.refuse()
    return replace(study, requests=requests)


def planned_study(document: Mapping, threads: int) -> Config:
    """Load the study of a job by its run's config; ValueError for a file edited since."""
    study = load_config(document)
    hold_to_plan(files_of(study))
    return study.but(threads=threads)


def files_of(study: Config) -> dict[str, str]:
    """Give the SHA-256 of each file that the config names, as it was read, by path."""
    return study.files() | merge(lambda part: part.files(study))


def doubts(study: Config) -> list[str]:
    """Warn, in lines, of values that are hardly meant and of what the model may leave out."""
    parts = attached().values()
    lines = doubts_of_core(study, [pair for part in parts for pair in part.records(study)])
    lines += [line for part in parts for line in part.doubts(study)]
    return list(dict.fromkeys(lines))  # a record may be that of several shocks

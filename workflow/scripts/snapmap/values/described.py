"""Records described in JSON Schema, for editors of YAML, and in docstrings, for help."""

import inspect
from typing import Any

from .fields import hints, instead_of, rows, summary, taken


class Docstring:
    """The docstring of a record, with its fields as parameters once someone reads it."""

    def __init__(self, text):
        """Take the text of the class."""
        self.text = text

    def __get__(self, whole, made):
        """Write it in the form of numpydoc."""
        if not self.text:
            return None
        text, heading, examples = inspect.cleandoc(self.text).partition("\n\nExamples\n")
        lines = [text, "", "Parameters", "----------"]
        for key, what, _, default, _ in rows(made):
            said = "" if default is None else f", default {default}"
            lines += [f"{key} : {taken(hints(made)[key])}{said}", f"    {what}"]
        return "\n".join(lines) + heading + examples


def described(made: type, core: Any, handler: Any) -> dict[str, Any]:
    """Describe a record to `schema`, with sentences and defaults as a config has them."""
    described = handler(core)
    whole = handler.resolve_ref_schema(described)
    whole.pop("title", None)
    whole["description"] = summary(made)
    whole["required"] = []
    for row in rows(made):
        about = whole["properties"][row.key]
        options = [part for part in about.pop("anyOf", ()) if part != {"type": "null"}]
        about |= options[0] if len(options) == 1 else {"anyOf": options} if options else {}
        for key in ("default", "title"):
            about.pop(key, None)
        about |= {"description": row.what}
        about |= {} if row.default is None else {"default": row.default}
        if row.required or "const" in about:
            whole["required"].append(row.key)
    if instead := {key: others for key, others in instead_of(made).items() if others}:
        whole["allOf"] = [
            {"anyOf": [{"required": [key]}, *map(_has, others)]} for key, others in instead.items()
        ]
    return described


def _has(part):
    """Describe a section that has a value; {} is any."""
    ((key, value),) = part.items()
    return {"required": [key]} | ({"properties": {key: {"const": value}}} if value else {})

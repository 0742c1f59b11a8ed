"""Sphinx makes a site of README.md and docs/ as they stand, its formulas in MathML.

./run sphinx-build -EW -c docs/site . build/site
"""

import re

from docutils.nodes import SkipNode
from math_core import LatexToMathML
from ziamath import fonts

project = html_title = "snapmap"
extensions = ["myst_parser"]
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3
root_doc = "README"
include_patterns = ["*.md", "docs/**.md"]
exclude_patterns = [".*", "build", "results"]

html_theme = "furo"
html_math_renderer = "mathml"
html_css_files = ["style.css"]
html_static_path = ["style.css", f"{fonts.__path__[0]}/STIXTwoMath-Regular.ttf"]
html_extra_path = ["index.html"]
html_copy_source = False

CONTENTS = """
```{toctree}
:hidden:
:caption: Use
Tutorial <docs/tutorial>
docs/recipes
Config <docs/config>
Shocks <docs/pulses>
Own physics <docs/own-physics>
docs/figures
Functions <docs/reference>
Running <docs/running>
```
```{toctree}
:hidden:
:caption: Applications
:glob:
docs/applications/*
```
```{toctree}
:hidden:
:caption: Evidence
Theory <docs/theory>
docs/thresholds
Accuracy <docs/accuracy>
docs/validation
Limits <docs/limits>
```
```{toctree}
:hidden:
:caption: Project
docs/architecture
CONTRIBUTING
CHANGELOG
SUPPORT
CODE_OF_CONDUCT
```
"""
# Chromium neither stretches a fence that carries a script nor takes a font's primes for scripts.
SCRIPTED_FENCE = re.compile(r"(?<=su[bp]>)<mo m.*?</mo>")
PRIME = re.compile(r"<mo>(?=[′″‴⁗])")


def setup(app):
    app.add_html_math_renderer("mathml", _formula(displayed=False), _formula(displayed=True))
    app.connect("source-read", complete)


def _formula(displayed):
    def write(translator, node):
        text = to_mathml(node.astext(), displaystyle=displayed)
        text = SCRIPTED_FENCE.sub(r"<mrow>\g<0></mrow>", text)
        translator.body.append(PRIME.sub('<mo class="prime">', text))
        raise SkipNode

    to_mathml = LatexToMathML().convert_with_local_state
    return write, None


def complete(app, page, source):
    """Give the first page the contents."""
    if page == root_doc:
        source[0] += CONTENTS

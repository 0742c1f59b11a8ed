"""The value of a device that gives a threshold or meets requirements.  Imports: core alone."""

from __future__ import annotations

from ..application import Application


class Design(Application):


application = Design()

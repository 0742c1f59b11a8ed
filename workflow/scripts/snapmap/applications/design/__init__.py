"""The value of a device that gives a threshold or meets requirements.  Imports: core alone."""

from ..application import Application

application = Application()

"""A study: its axes, its devices under its shocks, and the attributes of its products."""

from .study import Study

__all__ = ["Study"]

"""A study: its axes, its devices under its shocks, and what its products say of themselves."""

from .study import Study

__all__ = ["Study"]

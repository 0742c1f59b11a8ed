"""The clamped beam: discretisations, each a `Basis`; its modes, equilibria, limit loads, stress."""

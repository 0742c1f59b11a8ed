"""Labelled maps as the literature judges them: integrity, erosion, entropy, uncertainty."""

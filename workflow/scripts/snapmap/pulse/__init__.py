"""The shock: shapes of pulses, trains of blows, recorded pulses, and the directions of a study."""

"""Every source of error of a simulation, measured one at a time, and the time it takes."""

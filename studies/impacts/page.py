"""The text of README.md."""

TEXT = r"""# A benchmark: ensembles of small systems with impacts

Five problems with known answers for solvers of thousands of small, stiff systems with impacts:

    ./run python -m studies impacts > studies/impacts/README.md

Another solver takes part by a function in
`solvers.py` and a line in `contenders` of `__main__.py`.

## The problems

Each trajectory begins at $t = 0$; the result is $x(t_\mathrm{{end}})$. Values of a range are evenly
spaced; two ranges make a grid, its last one running fastest.

1. **Bouncing ball.** $x'' = -1$, $x(0) = 1$, $x'(0) = 0$; at $x = 0$ the speed is reversed and
   multiplied by $e$. Bounce $n$ is at $t_n = \sqrt 2\,(1 + 2(e + e^2 + \dots + e^n))$, before
   $t_\infty = \sqrt 2\,(1 + e)/(1 - e)$. 16 values of $e$ from 0.5 to 0.9, and 16 of
   $t_\mathrm{{end}}/t_\infty$ from 0.6 to 1.1. A ball slower than 1e-4 may be taken for one at
   rest.
2. **Impact oscillator.** $x'' + x = -\sin \omega t$, from rest at 0; at $x = -0.5$ the speed is
   reversed and multiplied by $e$. 16 values of $\omega$ from 0.9 to 2.6, 16 of $e$ from 0.7 to 0.9,
   $t_\mathrm{{end}} = 30$. The answer is sines between impacts.
3. **Bilinear oscillator.** The same with a soft stop: $x'' + x + 100 \min(0, x + 0.5) = -\sin
   \omega t$. 256 values of $\omega$ from 1.1 to 2.6. The answer is sines in and out of contact.
4. **Relief valve** (Hős and Champneys, Physica D 241, 2012; MPGOS' example): $x_1' = x_2$,
   $x_2' = -1.25 x_2 - (x_1 + 10) + x_3$, $x_3' = 20 (q - x_1 \sqrt{{x_3}})$; at $x_1 = 0$ the speed
   is reversed and multiplied by 0.8. From $(0.2, 0, 10)$, so that no valve rattles to rest. 256
   values of $q$ from 0.2 to 7, $t_\mathrm{{end}} = 10$. The answer is that of SciPy's DOP853
   at 1e-13.
5. **Snap or no snap.** The handout's device in three cosines ([theory](../../docs/theory.md)), with
   soft contact and C = 0.025: 16 values of N from 600 to 2400, 16 of f0 from 300 Hz to 20 kHz
   by ratio. The label is whether $w_\mathrm{{mid}}$ reaches the second shape within 1500 us
   after the pulse. The answer is that of the plain loop at {fine:g} us. Left out are
   {contested} cells whose label turns with N by up to 0.2 %. Of the other {cells}, {snap}
   snap.

The first and the last trajectory of each:

{answers}
## Results

{machine}, one thread; {versions}.
CPU time when compiled, the median of {rounds} rounds in turns. **Only ratios
count**: rates do not carry to another machine.

Trajectories per second, *loose* and *tight*: within 1e-3 and 1e-6 of the answer for all but 5 % of
them, as those near grazing have no bounded error; of the labels, all but one in a hundred, and all.
Each contender has the fastest *setting* that meets the bound (– for none): the tolerance, then the
longest step, if limited; the step of the plain loop; for snapmap the number of steps, on the map
its step times this. SciPy follows every ninth trajectory and every 29th cell.

{table}
SciPy is DOP853 of `solve_ivp`, begun again after each impact, its right-hand side compiled by
numba. The plain loop is the classical Runge-Kutta method in fixed steps, compiled by numba, with
impacts by bisection.
snapmap is its kernel, which is of second order and so weak where many digits are wanted; in the
first two problems it follows a mass before a stop, with the beam out of reach. It has neither a
soft stop without a beam nor the third equation of a valve.

Left out: numbalsoda 0.3.4 (source only, needs a Fortran compiler), numbakit-ode 0.5 (methods with a
tolerance raise a TypeError), MPGOS (needs an NVIDIA GPU), DifferentialEquations.jl (needs Julia).
"""

"""Fit of parameters and latency to a log, with `mujoco.sysid`.

Parameters, least squares and intervals are those of mujoco.sysid. Its residual delays what is
measured, not what is commanded, and its squares follow the jumps of saturated actuators: with
them damping is 4 to 54 % off (docs/identify.md). `Replay.residual` and a Cauchy loss take their
place.
"""

from __future__ import annotations

import contextlib
import io
from collections.abc import Callable
from pathlib import Path
from typing import TypeAlias

import mujoco
import numpy as np
from mujoco import rollout, sysid
from numpy.typing import NDArray
from scipy.optimize import OptimizeResult

from mpma_mj.envs.model_validation import check_geometry
from mpma_mj.envs.options import EnvironmentOptions
from mpma_mj.envs.physics import PhysicsArms
from mpma_mj.errors import BadOptionError
from mpma_mj.kinematics import JOINT_NAMES
from mpma_mj.options import TWO_ARM
from mpma_mj.robots.robot_file import read_robot
from mpma_mj.sysid.log import RobotLog, check_log
from mpma_mj.sysid.parameters import LATENCY, REFERENCE, UNITS, scaled, values
from mpma_mj.sysid.replay import Replay
from mpma_mj.sysid.report import (
    FARTHEST,
    LONGEST,
    SHOWN_WINDOW,
    Estimate,
    Identified,
    Latency,
    is_determined,
)
from mpma_mj.utils.system import processors

__all__ = ["half_widths", "identify"]

Array = NDArray[np.float64]
Residual: TypeAlias = "Callable[[sysid.ParameterDict], Array]"

_WINDOW = 0.25  # s; of the fit (choice: where actuators saturate, longer ones go astray)
_FEWEST_ROWS = 3  # of a window, as the mean of its angles is taken out
_SEARCHED = 60  # windows of the first search (choice)
_COARSE, _FINE = 1e-3, 1e-4  # relative changes at which a search ends
_STEPS = (1e-4, -1e-4, 1e-4)
"""Relative steps of derivatives, of one search after the other (choice). A difference across a
jump is no derivative and ends a search early; a step to the other side continues from there."""
_MOST_ITERATIONS = 30
_NEAR = 3  # physics steps of latency that are tried on both sides (choice)
_RESOLUTION = 1e-4  # rad; no log is taken to be more exact (choice)


def identify(
    log: RobotLog,
    *,
    robot: str | Path = TWO_ARM,
    gravity_compensation: bool = False,
    tick: Callable[[], None] = lambda: None,
) -> Identified:
    """Find the parameters with which simulated arms reproduce a log.

    Where the log does not show their common scale, `REFERENCE` is left as in the model.

    Args:
        log: Commands and measurements.
        robot: MJCF file of your arms, with the joints of `two_arm`.
        gravity_compensation: Whether the robot compensates for gravity.
        tick: Called after each simulation of the log.

    Raises:
        BadOptionError: The model cannot be read or lacks something, or the extra `sysid` is not
            installed.
        RobotLogError: The log is too short, too coarse, or shows no motion.
        DivergedError: A simulation diverged.
    """
    if not hasattr(sysid, "optimize"):  # which imports without what it needs
        raise BadOptionError(
            "identification needs libraries that are not installed; in the checkout, pip install"
            " -e '.[sysid]'"
        )
    if not read_robot(robot).complete:
        expected = "two_arm, or an MJCF file with its joints, whose parameters are fitted"
        raise BadOptionError(option="robot", value=robot, expected=expected)
    physics = PhysicsArms.make(
        EnvironmentOptions(robot=str(robot), gravity_compensation=gravity_compensation)
    )
    if robot != TWO_ARM:
        check_geometry(Path(robot), physics)
    arms: mujoco.MjModel = physics.model.ptr
    timestep = float(arms.opt.timestep)
    steps = check_log(log, arms)
    longest = round(LONGEST / timestep)
    own = values(arms)
    names = [name for name in UNITS if own[name].any()]
    with rollout.Rollout(nthread=processors()) as pool:

        def windows(seconds: float, most: int) -> Replay:
            length = max(_FEWEST_ROWS, round(seconds / log.period))
            starts = np.arange(longest // steps + 2, len(log) - length, length)
            starts = starts[:: max(1, len(starts) // most)]
            return Replay(pool, arms, log, starts, length, steps)

        def simulated(parameters: sysid.ParameterDict) -> tuple[mujoco.MjModel, float]:
            factors = {name: parameters[name].value.item() for name in names}
            return scaled(arms, factors), longest * parameters[LATENCY].value.item()

        def residual_of(replay: Replay) -> Residual:
            def residual(parameters: sysid.ParameterDict) -> Array:
                tick()
                return replay.residual(*simulated(parameters))

            return residual

        coarse, fine = (residual_of(windows(_WINDOW, most)) for most in (_SEARCHED, len(log)))
        found, result = _fit(names, longest, coarse, fine)
        reference = names.index(REFERENCE)
        widths, ratio_widths = half_widths(result.fun, result.jac, reference)
        factors = found.as_vector()[:-1]
        widths[:-1], ratio_widths = widths[:-1] / factors, ratio_widths[:-1] / factors
        if not is_determined(widths[reference]):  # a common factor moves nothing
            factors = factors / factors[reference]
        latency = min(max(found[LATENCY].value.item(), 0.0), 1.0)
        found.update_from_vector(np.append(factors, latency))
        shown = windows(SHOWN_WINDOW, len(log))
        before, after = shown.simulate(arms, 0.0), shown.simulate(*simulated(found))
    return Identified(
        tuple(
            Estimate(name, own[name], *numbers)
            for name, *numbers in zip(
                names, factors.tolist(), widths[:-1].tolist(), ratio_widths.tolist(), strict=True
            )
        ),
        tuple(name for name in UNITS if name not in names),
        Latency(
            timestep * longest * latency,
            timestep * max(0.5, longest * float(widths[-1])),
            timestep * steps,
        ),
        log.time[shown.rows],
        *(angles[..., : len(JOINT_NAMES)] for angles in (shown.logged, before, after)),
    )


def _fit(
    names: list[str], longest: int, coarse: Residual, fine: Residual
) -> tuple[sysid.ParameterDict, OptimizeResult]:
    """Fit factors on parameters, and the latency.

    Latency is searched over whole physics steps, in turns with the parameters; then all are fitted
    together.

    Args:
        names: Names of P parameters.
        longest: Longest latency, physics steps.
        coarse: Residual of some windows, for the search.
        fine: Residual of all windows.

    Returns:
        Factors, and the latency as a part of the longest; SciPy's result, with residual and
        derivatives.
    """
    parameters = sysid.ParameterDict()
    for name in names:
        parameters.add(sysid.Parameter(name, 1.0, 1.0 / FARTHEST, FARTHEST))
    margin = 1.0 / longest  # a physics step, as a search may not start at a bound
    parameters.add(sysid.Parameter(LATENCY, 0.0, -margin, 1.0 + margin, frozen=True))

    def size(latency: int) -> float:
        parameters[LATENCY].value[:] = latency / longest
        return float(np.abs(coarse(parameters)).mean())

    tried: set[int] = set()
    latency = min(range(longest + 1), key=size)
    while latency not in tried:
        tried.add(latency)
        parameters[LATENCY].value[:] = latency / longest
        parameters, _ = _optimize(parameters, coarse, _COARSE, _STEPS[0])
        near = range(max(0, latency - _NEAR), min(longest, latency + _NEAR) + 1)
        latency = min(near, key=size)
    parameters[LATENCY].value[:] = latency / longest
    parameters[LATENCY].frozen = False
    for step in _STEPS:
        parameters, result = _optimize(parameters, fine, _FINE, step)
        if np.median(np.abs(result.fun)) < _RESOLUTION:  # nothing is left to be found
            break
    return parameters, result


def _optimize(
    parameters: sysid.ParameterDict, residual: Residual, tolerance: float, step: float
) -> tuple[sysid.ParameterDict, OptimizeResult]:
    """Return the parameters that minimise the Cauchy loss, and SciPy's result.

    The scale of the loss is the standard deviation that the residual's median size suggests.
    """

    def vary(x: Array, varied: sysid.ParameterDict) -> tuple[list[Array], None, None]:
        varied.update_from_vector(x)
        return [residual(varied)], None, None

    start = parameters.copy().move_off_bounds()
    scale = 1.4826 * float(np.median(np.abs(residual(start))))
    with contextlib.redirect_stdout(io.StringIO()):  # SciPy's iterations; no option hides them
        return sysid.optimize(
            start,
            vary,
            "scipy",
            verbose=False,
            loss="cauchy",
            f_scale=max(scale, _RESOLUTION),
            diff_step=step,
            xtol=tolerance,
            ftol=tolerance,
            max_iters=_MOST_ITERATIONS,
        )


def half_widths(residual: Array, jacobian: Array, reference: int) -> tuple[Array, Array]:
    """Return half widths of 95 % intervals: of parameters, and if one of them were known.

    As the common scale of parameters may be open, the latter are those of ratios to it.

    Args:
        residual: Residual at the optimum, shape (N,), rad.
        jacobian: Its derivatives, shape (N, P).
        reference: Number of the parameter that is taken as known; its half width is 0.

    Returns:
        Half widths, each shape (P,); infinite where the residual does not depend on a parameter.
    """
    blurred = [np.hypot(residual, _RESOLUTION)]
    _, widths = sysid.calculate_intervals(blurred, jacobian)
    _, others = sysid.calculate_intervals(blurred, np.delete(jacobian, reference, axis=1))
    return widths, np.insert(others, reference, 0.0)

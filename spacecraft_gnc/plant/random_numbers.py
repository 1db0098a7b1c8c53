"""Counter-based random numbers: the same for any number of workers, with or without ROS."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

import numpy as np

from spacecraft_gnc.parameters.parameter import Kind, NodeParameters, parameter
from spacecraft_gnc.types import Array

LARGEST_SEED = 2**63 - 1


@dataclass(frozen=True, kw_only=True, eq=False, init=False, repr=False)
class SeedParameters(NodeParameters):
    """What all random numbers of a section depend on."""

    seed: int = parameter(
        Kind.INTEGER, 0, "master seed of all random numbers", minimum=0, is_neutral=True
    )
    run: int = parameter(
        Kind.INTEGER,
        0,
        "run of a campaign: other random numbers of the same seed",
        minimum=0,
        is_neutral=True,
    )


def generator(seed: int, run: int, stream: str, step: int) -> np.random.Generator:
    """Return the generator whose numbers depend on these four alone.

    There is no state that somebody has to keep: a step can be drawn without those before it, and a
    run without the other runs.

    Parameters
    ----------
    seed, run : int
        Master seed, and the run of a campaign: 0 to 2^63 - 1.
    stream : str
        What the numbers are for, such as ``"disturbances.noise"``. Streams of different names are
        independent.
    step : int
        Control step, from 0.

    Notes
    -----
    Philox-4x64-10 with the key (seed, run); the counter starts at (0, stream, step, 0) and a step
    has 2^64 blocks of it to itself. The bits are those of Philox on every machine; the numbers
    made of them are NumPy's, and may differ between its releases.

    Source: Salmon et al., "Parallel random numbers: as easy as 1, 2, 3", SC 2011.
    """
    digest = hashlib.sha256(stream.encode()).digest()
    number = int.from_bytes(digest[:8], "big") & LARGEST_SEED
    return np.random.Generator(np.random.Philox(key=[seed, run], counter=[0, number, step, 0]))


def standard_normals(seed: int, run: int, stream: str, step: int, count: int) -> Array:
    """Return ``count`` independent standard normal numbers; arguments as of `generator`."""
    return generator(seed, run, stream, step).standard_normal(count)


def uniforms(seed: int, run: int, stream: str, step: int, count: int) -> Array:
    """Return, likewise, ``count`` independent numbers uniform in [0, 1), multiples of 2^-53."""
    return generator(seed, run, stream, step).random(count)

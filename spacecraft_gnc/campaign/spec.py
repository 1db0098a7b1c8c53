"""Identity of a campaign: what its rows depend on, and nothing else."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass, fields
from functools import cached_property, lru_cache
from typing import Any, Final

from spacecraft_gnc import __version__
from spacecraft_gnc.arguments import as_count
from spacecraft_gnc.campaign.design import Design
from spacecraft_gnc.campaign.sampling import MOST_RUNS
from spacecraft_gnc.campaign.variations import Variations, load_variations
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.scenario import Scenario
from spacecraft_gnc.scenario.fingerprint import differences
from spacecraft_gnc.scenario.provenance import lock_file, version_of
from spacecraft_gnc.scenario.template import Template

_LIBRARIES: Final = ("numpy", "scipy", "numba")  # whose bits the flights depend on
_PATHS: Final = ("scenario_path", "variations_path")
_HERE: Final = ("package_version", "lock_sha256", "libraries")


@dataclass(frozen=True)
class Spec:
    """Everything that the rows of a campaign depend on; small, and sent to the workers as it is.

    Attributes
    ----------
    scenario_text : str
        The scenario, with what ``--set`` laid over it.
    defaults_text : str
        The defaults that it took by formulas.
    variations_text : str
        The variations file.
    variations_path : str
        Where it came from; no part of the identity.
    seed : int
        Master seed.
    runs : int
        Number of runs.
    package_version, lock_sha256 : str
        Version of this package, and hash of its lock file; empty where none came with it.
    libraries : str
        Versions of the libraries whose bits the flights depend on.
    scenario_path : str
        Where the scenario came from; no part of the identity.
    """

    scenario_text: str
    defaults_text: str
    variations_text: str
    variations_path: str
    seed: int
    runs: int
    package_version: str
    lock_sha256: str
    libraries: str = ""
    scenario_path: str = ""

    @classmethod
    def of(cls, scenario: Scenario, variations: Variations, seed: int, runs: int) -> Spec:
        """Return the campaign of a scenario and its variations, flown by what is installed here."""
        return cls(
            scenario_text=scenario.to_yaml(),
            defaults_text=scenario.stated_defaults(),
            variations_text=variations.text,
            variations_path=str(variations.path),
            seed=seed,
            runs=runs,
            scenario_path=scenario.path,
            **installed(),
        )

    def __getstate__(self) -> dict[str, Any]:
        """Return the fields alone: what is made of them, each process makes for itself."""
        return asdict(self)

    @cached_property
    def identity(self) -> str:
        """SHA-256 of the fields, paths left out."""
        values = {name: value for name, value in asdict(self).items() if name not in _PATHS}
        return hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()

    @cached_property
    def template(self) -> Template:
        """What the scenarios of the runs are made of."""
        return Template(self.scenario_path, text=self.scenario_text)

    @cached_property
    def scenario(self) -> Scenario:
        """The scenario that the variations are laid over."""
        return self.template.scenario()

    @cached_property
    def variations(self) -> Variations:
        """What varies, and how."""
        return load_variations(self.variations_path, self.scenario, self.variations_text)

    @cached_property
    def design(self) -> Design:
        """The point of each run."""
        return Design(self.variations, self.seed, self.runs)

    def to_dict(self) -> dict[str, Any]:
        """Return the fields, ready for JSON."""
        return asdict(self)

    @classmethod
    def from_dict(cls, values: dict[str, Any]) -> Spec:
        """Return the campaign that `to_dict` was of; further entries are passed over."""
        return cls(**{field.name: values[field.name] for field in fields(cls)})

    def differences(self, other: Spec) -> tuple[str, ...]:
        """Return in what another campaign differs from this one, a text for each."""
        return tuple(self._differences(other))

    def _differences(self, other: Spec) -> Iterator[str]:
        for name in ("seed", "runs", *_HERE):
            ours, theirs = getattr(self, name), getattr(other, name)
            if ours != theirs:
                yield f"{name} {_shown(theirs)} instead of {_shown(ours)}"
        if self.variations_text != other.variations_text:
            yield "other variations"
        if (self.scenario_text, self.defaults_text) != (other.scenario_text, other.defaults_text):
            yield from self._scenario_differences(other)

    def _scenario_differences(self, other: Spec) -> Iterator[str]:
        found = differences(self.scenario, other.scenario)
        if not found:
            yield "another scenario text"
        for each in found:
            yield f"{each.name} {each.second} instead of {each.first}"


def runs_of(variations: Variations, given: int | None) -> int:
    """Return the number of runs: the given one, else that of the file or of its grid.

    Raises
    ------
    ParameterError
        If neither says any, or it is less than 1.
    """
    runs = variations.default_runs if given is None else given
    if runs is None:
        raise ParameterError(
            f"--runs: received nothing, and {variations.path} has none; required a number of runs; "
            "give for example --runs 1000"
        )
    return as_count("--runs", runs, most=MOST_RUNS, remedy="give for example --runs 1000")


@lru_cache(maxsize=1)
def installed() -> dict[str, str]:
    """Return what is installed here, by the names of the fields of a `Spec`."""
    lock = lock_file()
    return {
        "package_version": __version__,
        "lock_sha256": hashlib.sha256(lock).hexdigest() if lock else "",
        "libraries": ", ".join(f"{name} {version_of(name)}" for name in _LIBRARIES),
    }


def require_installed(spec: Spec, where: str) -> None:
    """Refuse a machine whose flights would be those of other versions.

    Raises
    ------
    ParameterError
        With what differs.
    """
    here = installed()
    wrong = [name for name in _HERE if here[name] != getattr(spec, name)]
    if wrong:
        received = ", ".join(f"{name} {_shown(here[name])}" for name in wrong)
        wanted = ", ".join(f"{name} {_shown(getattr(spec, name))}" for name in wrong)
        raise ParameterError(
            f"{where}: received {received}; required {wanted}, as of the campaign; install the "
            "same versions there"
        )


def _shown(value: object) -> object:
    return "unknown" if value == "" else value

"""Tests of descriptors: everything that one names can be loaded."""

from __future__ import annotations

import dataclasses

import pytest

from spacecraft_gnc.lazy import Lazy
from spacecraft_gnc.vehicles.registry import VEHICLES, own_names, vehicle_of


def _lazies(described):
    """Yield (name, lazy) of a descriptor, its methods and its laws."""
    for field in dataclasses.fields(described):
        value = getattr(described, field.name)
        if isinstance(value, Lazy):
            yield f"{described.name}.{field.name}", value
        elif isinstance(value, tuple):
            for part in value:
                if dataclasses.is_dataclass(part):
                    yield from _lazies(part)


@pytest.mark.parametrize("vehicle", own_names(VEHICLES))
def test_everything_that_a_descriptor_names_can_be_loaded(vehicle):
    lazies = dict(_lazies(vehicle_of(vehicle)))
    assert len(lazies) > 10
    for lazy in lazies.values():
        assert lazy.load() is not None

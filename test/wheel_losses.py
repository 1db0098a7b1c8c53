"""Sections of the shipped scenarios that lose a wheel, with some values changed."""

from __future__ import annotations

from pathlib import Path

import yaml

CONFIG = Path(__file__).parents[1] / "config"
THREE, FOUR = "afrl_wheel_loss", "afrl_wheel_loss_pyramid"


def scenario_sections(name=THREE, lost=None, controller=None, **plant):
    """Return the sections of a shipped scenario with other losses and further values.

    ``lost``: times of loss [s] by the number of the wheel, for those of the scenario.
    """
    text = yaml.safe_load((CONFIG / f"{name}.yaml").read_text(encoding="utf-8"))
    wanted = ("plant", "nmpc_controller", "reference_governor")
    sections = {section: text[section]["ros__parameters"] for section in wanted}
    values = sections["plant"]
    if lost is not None:
        values["wheel_lost_at"] = [lost.get(i, -1.0) for i in range(len(values["wheel_inertias"]))]
    if plant.get("wheel_loss", "friction") != "friction" or max(values["wheel_lost_at"]) < 0.0:
        del values["lost_wheel_friction"]
    values.update(plant)
    sections["nmpc_controller"].update(controller or {})
    return sections

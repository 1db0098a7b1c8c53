"""One scenario: a ROS 2 parameter file, checked without ROS, and the cores built from it."""

from spacecraft_gnc.parameters.problems import InvalidScenario, Problem
from spacecraft_gnc.scenario.fleet import Fleet, load_fleet
from spacecraft_gnc.scenario.load import from_sections, load, read_sections
from spacecraft_gnc.scenario.revision import revise
from spacecraft_gnc.scenario.scenario import Scenario
from spacecraft_gnc.scenario.template import Template

__all__ = [
    "Fleet",
    "InvalidScenario",
    "Problem",
    "Scenario",
    "Template",
    "from_sections",
    "load",
    "load_fleet",
    "read_sections",
    "revise",
]

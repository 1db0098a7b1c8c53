"""The scenario of a live graph is learned however rarely its observer looks."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from rcl_interfaces.msg import ParameterType, ParameterValue

from spacecraft_gnc.ros import setup_reader


class Client:
    """Parameter client of a node that answers at once."""

    def __init__(self, *_):
        self.asked = 0

    def services_are_ready(self):
        return True

    def list_parameters(self):
        self.asked += 1
        return self.answer(result=SimpleNamespace(names=["method"]))

    def get_parameter_types(self, names):
        return self.answer(types=[ParameterType.PARAMETER_STRING for _ in names])

    def get_parameters(self, names):
        value = ParameterValue(type=ParameterType.PARAMETER_STRING, string_value="lqr")
        return self.answer(values=[value for _ in names])

    @staticmethod
    def answer(**parts):
        return SimpleNamespace(done=lambda: True, result=lambda: SimpleNamespace(**parts))


@pytest.mark.parametrize("every", [0.1, 1.0, 5.0])
def test_answers_are_taken_before_a_node_is_asked_again(monkeypatch, every):
    monkeypatch.setattr(setup_reader, "AsyncParameterClient", Client)
    question = setup_reader._Question(None, "/controller", "method")
    for k in range(4):  # one question each for names, types and values
        assert question.values == {}
        question.poll(every * k)
    assert question.values == {"method": "lqr"}
    assert question._client.asked == 1

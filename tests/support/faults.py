"""The faults of a text that is refused, by their keys."""

import pytest

from fingerdesign.checks.load import parse_design
from fingerdesign.errors import DesignError


def faults_of(text, parse=parse_design):
    with pytest.raises(DesignError) as caught:
        parse(text)
    return {fault.key: fault for fault in caught.value.faults}

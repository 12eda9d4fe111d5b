"""The schema of ``summary.json``: it is one, solutions are as it says, and every key of it is an attribute."""

from __future__ import annotations

import json
from pathlib import Path

import jsonschema
import pytest

import dotyk
import dotyk.examples
from dotyk import _solution

ROOT = Path(__file__).resolve().parents[3]
SCHEMA = json.loads((ROOT / "docs" / "reference" / "summary.schema.json").read_text())


def faults(summary):
    validator = jsonschema.Draft202012Validator(SCHEMA)
    return [f"{fault.json_path}: {fault.message}" for fault in validator.iter_errors(summary)]


def summary(solution):
    return json.loads(solution._run.summary())


def test_it_is_a_schema_and_refuses_what_it_does_not_know():
    jsonschema.Draft202012Validator.check_schema(SCHEMA)
    told = summary(dotyk.examples.punch().solve())
    assert faults(told) == []
    assert len(faults({**told, "further": 1})) == 1
    assert len(faults({**told, "schema": 2})) == 1
    told["bodies"][0]["reaction"] = [1.0]
    assert len(faults(told)) == 1


def test_models_of_every_kind_are_told_as_it_says(tmp_path):
    pieces = dotyk.examples.punch().solve(subdomains=5)
    assert faults(summary(pieces)) == [] and pieces.subdomains == 5 and pieces.glue_iterations > 0
    steps = dotyk.examples.punch().solve(steps=[0.5, ("last", 1.0)])
    assert faults(summary(steps)) == [] and len(summary(steps)["steps"]) == 2
    assert faults(summary(dotyk.examples.boxes().solve())) == []
    with pytest.raises(dotyk.NotConverged) as caught:
        dotyk.examples.punch().solve(steps=[0.5, 1.0], method="gradient", max_iterations=1)
    told = summary(caught.value.solution)
    assert faults(told) == [] and told["converged"] is False


def test_every_key_is_an_attribute():
    kinds = {
        "step": _solution.Solution,
        "contact": _solution.ContactSolution,
        "body": _solution.BodySolution,
        "probe": _solution.ProbeValue,
    }
    tables = {"summary": SCHEMA, **SCHEMA["$defs"]}
    for name, kind in {"summary": _solution.Solution, **kinds}.items():
        assert set(tables[name]["properties"]) - set(kind.__annotations__) == set(), name
    assert set(SCHEMA["$defs"]["figure"]["properties"]) == set(_solution.Figure._fields)
    s = dotyk.examples.punch().solve(steps=[0.5, 1.0])
    assert [step.schema for step in s.steps] == [1, 1]

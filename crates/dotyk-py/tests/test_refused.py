"""What would be taken for something else is refused: masked numbers, changes of a model that is being solved, names of files."""

from __future__ import annotations

import copy
import threading

import numpy as np
import pytest

import dotyk
import dotyk.examples


def square():
    return dotyk.rectangle([0, 0], [1, 1], cells=[1, 2])


def loaded_by(pressure):
    m = dotyk.Model("plane-strain", parameters={"q": 1.0})
    m.body("a", square(), young=1e3, poisson=0.0).fix("bottom", x=0, y=0).load("top", pressure=pressure)
    return m


def model():
    return loaded_by("q")


def masked(*values):
    return np.ma.array(values, mask=[False] * len(values))


POINTS = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]
HALF = np.ma.array(POINTS, mask=[[0, 0], [0, 1], [0, 0]])

MASKED = {
    "points": lambda: dotyk.Mesh(HALF, {"tri3": [[0, 1, 2]]}),
    "rows of points": lambda: dotyk.Mesh(list(HALF), {"tri3": [[0, 1, 2]]}),
    "cells": lambda: dotyk.Mesh(POINTS, {"tri3": np.ma.array([[0, 1, 2]], mask=False)}),
    "sides": lambda: dotyk.Mesh(POINTS, {"tri3": [[0, 1, 2]]}, {"low": np.ma.array([[0, 1]], mask=True)}),
    "named": lambda: dotyk.Mesh(POINTS, {"tri3": [[0, 1, 2]]}, named={"tip": masked(0, 1)}),
    "corner": lambda: dotyk.rectangle(masked(0, 0), [1, 1], cells=[1, 1]),
    "number": lambda: model().bodies["a"].load("top", pressure=np.ma.array(1.0)),
    "nothing": lambda: model().bodies["a"].load("top", pressure=np.ma.masked),
    "vector": lambda: model().bodies["a"].load("top", traction=masked(0, 1)),
    "table": lambda: model().body("b", square(), young=1, poisson=0, points={"p": masked(0, 0)}),
    "parameter": lambda: model().solve(parameters={"q": np.ma.masked}),
    "steps": lambda: model().solve(steps=masked(0.5, 1.0)),
    "tolerance": lambda: model().solve(tolerance=np.ma.masked),
    "vary": lambda: model().study(vary={"q": masked(1.0, 2.0)}),
    "probe": lambda: model().solve().probe("a.stress.yy", at=masked(0.5, 0.5)),
    "forces": lambda: dotyk.examples.punch().dual().certify(np.ma.zeros(22), np.zeros(1)),
    "function": lambda: loaded_by(lambda p, t: np.ma.ones(len(p))).solve(),
}  # fmt: skip

@pytest.mark.parametrize("kind", MASKED)
def test_masked_arrays_are_no_numbers(kind):
    with pytest.raises(dotyk.InputError, match="masked arrays of NumPy are no numbers"):
        MASKED[kind]()


CHANGES = {
    "body": lambda m: m.body("b", square(), young=1, poisson=0),
    "load": lambda m: m.bodies["a"].load("top", pressure=5.0),
    "fix": lambda m: m.bodies["a"].fix("left", x=0),
    "body_force": lambda m: m.bodies["a"].body_force([0, -1]),
    "points": lambda m: m.bodies["a"].points(tip=[1, 1]),
    "contact": lambda m: m.contact("floor", nonmortar="a.bottom", obstacle={"gap": 0.0}),
    "bar": lambda m: m.bar("bolt", from_=[0, 0], to=[0, 1], bodies=["a"], young=1, area=1),
    "spring": lambda m: m.spring("buffer", from_=[0, 0], to=[0, 1], bodies=["a"], stiffness=1),
    "bolt": lambda m: m.bolt("stud", body="a", at=[0.5, 0.5], axis=[0, 1], prestress=1),
    "section": lambda m: m.section("cut", body="a", sides=["left", "right"], stations=[[0.5, 0.5]]),
    "probe": lambda m: m.probe("p", "a.stress.yy", at=[0.5, 0.5]),
    "step": lambda m: m.step(2.0),
}


def pressed(solution):
    return round(solution.bodies["a"].reaction[1], 9)


@pytest.mark.parametrize("change", CHANGES)
def test_a_model_cannot_be_changed_while_it_is_solved(change):
    m = model()
    with pytest.raises(dotyk.InputError, match="a model cannot be changed while it is solved"):
        m.solve(callback=lambda progress: CHANGES[change](m))
    # whatever was raised, it can be changed again
    assert pressed(m.solve()) == 1.0
    CHANGES[change](m)


def test_the_answer_is_that_of_the_model_at_the_call():
    m, seen = model(), []

    def observe(progress):
        seen.append((repr(m), m.check().errors, m.bodies["a"].mesh.points.shape))
        # what is refused may be passed over, and copies are other models
        with pytest.raises(dotyk.InputError):
            m.bodies["a"].load("top", pressure=5.0)
        copy.deepcopy(m).bodies["a"].load("top", pressure=5.0)

    assert pressed(m.solve(callback=observe)) == 1.0
    assert seen and all(told == seen[0] for told in seen)
    m.bodies["a"].load("top", pressure=5.0)
    assert pressed(m.solve()) == 6.0


def test_a_solve_inside_of_a_solve_opens_nothing():
    m = model()

    def observe(progress):
        m.solve()
        with pytest.raises(dotyk.InputError, match="while it is solved"):
            m.step(2.0)

    m.solve(callback=observe)
    m.step(2.0)


def test_other_threads_cannot_change_it_either():
    m, refused = model(), []

    def change():
        try:
            m.step(2.0)
        except dotyk.InputError as error:
            refused.append(str(error))

    def observe(progress):
        thread = threading.Thread(target=change)
        thread.start()
        thread.join()

    m.solve(callback=observe)
    assert set(refused) == {"a model cannot be changed while it is solved"}


@pytest.mark.parametrize(
    ("name", "words"),
    [("CON", "Windows keeps the name `CON` for a device"), ("com3", "`com3_1`"), ("A", "differs from `a` in case alone"), ("n" * 201, "200")],
)
def test_a_body_has_a_name_that_a_file_can_have(name, words):
    with pytest.raises(dotyk.InputError, match=words) as caught:
        model().body(name, square(), young=1, poisson=0)
    assert str(caught.value).startswith(f"body `{name}`: ")

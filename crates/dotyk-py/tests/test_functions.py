"""Functions against expressions that say the same: random models, one asked point by point by the library, one by arrays."""

from __future__ import annotations

import random

import numpy as np
import pytest

import dotyk

#: An expression and its function, both of place and time.
SHAPES = [
    ("1 + 0.3*x", lambda p, t: 1 + 0.3 * p[:, 0]),
    ("t*(1 + 0.2*y)", lambda p, t: t * (1 + 0.2 * p[:, 1])),
    ("1 + 0.1*x*y*t", lambda p, t: 1 + 0.1 * p[:, 0] * p[:, 1] * t),
    ("0.5 + 0.5*t", lambda p, t: np.full(len(p), 0.5 + 0.5 * t)),
]


def pair(r, size):
    """A number times a shape, as an expression and as a function."""
    text, function = r.choice(SHAPES)
    return f"{size!r}*({text})", lambda points, t: size * function(points, t)


def build(seed):
    """The same random model twice: with expressions, and with functions."""
    r = random.Random(seed)
    space = r.random() < 0.25
    analysis = "3d" if space else r.choice(["plane-strain", "plane-stress", "axisymmetric"])
    cell = r.choice(["hex8", "hex20"] if space else ["quad4", "quad9", "tri6"])
    axis, dimension = (2, 3) if space else (1, 2)
    upright = "z" if space else "y"
    pressure, weight = pair(r, 1e5), pair(r, -2e3)
    gap, friction = pair(r, 1e-5), pair(r, 0.2)
    lift, stress = pair(r, -1e-5), pair(r, -5e3)
    heat = pair(r, 3.0)
    chosen = {key: r.random() < 0.6 for key in ("gap", "friction", "weight", "stress", "heat", "push")}
    models = []
    for k in (0, 1):
        m = dotyk.Model(analysis)
        lengths = [1.0, 1.0, 0.5] if space else [1.0, 0.5]
        counts = [2, 2, 1] if space else [4, 2]
        make = dotyk.box if space else dotyk.rectangle
        origin = [0.0] * dimension
        if analysis == "axisymmetric":
            origin, lengths = [0.5, 0.0], [1.5, 0.5]
        body = m.body("a", make(origin, lengths, cells=counts, cell=cell), young=1e8, poisson=0.25)
        if analysis != "axisymmetric":
            body.fix("left", x=0)
        if space:
            body.fix("front", y=0)
        if chosen["push"]:
            body.fix("top", **{upright: lift[k]})
        else:
            body.load("top", pressure=pressure[k])
        if chosen["weight"]:
            zero = ["0"] * dimension
            if k == 0:
                zero[axis] = weight[0]
                body.body_force(zero)
            else:

                def force(points, t):
                    out = np.zeros_like(points)
                    out[:, axis] = weight[1](points, t)
                    return out

                body.body_force(force)
        if chosen["stress"]:
            body.initial_stress(**{"xx": stress[k], "yy": stress[k], "zz": 0.0})
        if chosen["heat"]:
            body.initial_strain(thermal=heat[k], expansion=1e-6)
        obstacle = {"gap": gap[k] if chosen["gap"] else 0.0}
        law = {"friction": friction[k]} if chosen["friction"] else {}
        m.contact("floor", nonmortar="a.bottom", obstacle=obstacle, **law)
        models.append(m)
    return models


def solved(model):
    try:
        return model.solve(steps=[0.5, 1.0])
    except dotyk.NotConverged as error:
        return str(error)
    except dotyk.InputError as error:
        return str(error)


def agree(seed):
    expressions, functions = (solved(model) for model in build(seed))
    if isinstance(expressions, str) or isinstance(functions, str):
        # what has no answer has none either way
        return isinstance(expressions, str) and isinstance(functions, str)
    for one, other in zip(expressions.steps, functions.steps, strict=True):
        u, v = one.bodies["a"].displacement, other.bodies["a"].displacement
        # the order of multiplications differs: some roundings, which the solve magnifies
        scale = np.abs(u).max() + 1e-12
        if np.abs(u - v).max() > 1e-9 * scale:
            return False
        p, q = one.contacts["floor"].pressure, other.contacts["floor"].pressure
        if np.abs(p - q).max() > 1e-8 * (np.abs(p).max() + 1.0):
            return False
    return True


@pytest.mark.parametrize("seed", range(40))
def test_functions_give_what_expressions_give(seed):
    assert agree(seed)


@pytest.mark.parametrize("kind", ["plane-strain", "plane-stress", "axisymmetric", "3d"])
def test_functions_are_asked_once_in_each_place_and_step(kind):
    asked = []

    def numbers(name, value, vector=False):
        def function(points, t):
            asked.append((name, t))
            values = np.zeros_like(points if vector else points[:, 0])
            values[..., -1 if vector else slice(None)] = value
            return values

        return function

    space, first = kind == "3d", 1.0 if kind == "axisymmetric" else 0.0
    corner = [first + 2.0, 1.0] + [1.0] * space
    make = dotyk.box if space else dotyk.rectangle
    mesh = make([first, 0.0] + [0.0] * space, corner, cells=[4, 2] + [2] * space)
    m = dotyk.Model(kind)
    body = m.body("a", mesh, young=1e6, poisson=0.3)
    body.fix("left", x=numbers("held", 0.0))
    if space:
        body.fix("front", y=0)
    body.body_force(numbers("weight", -1.0, True))
    body.load("top", traction=numbers("traction", -5.0, True)).load("right", pressure=numbers("pressure", 1.0))
    body.load("top", force=numbers("resultant", -3.0, True)).load(point=corner, force=numbers("force", -1.0, True))
    body.initial_stress(xx=numbers("stress", -2.0), yy=0, zz=0).initial_strain(isotropic=numbers("strain", 1e-6))
    joint = {"coulomb": numbers("coefficient", 0.4), "cohesion": numbers("cohesion", 0.1), "tension": numbers("tension", 0.05)}
    m.contact("floor", nonmortar="a.bottom", obstacle={"gap": numbers("gap", 1e-6)}, friction=joint)
    times = [0.5, 1.0, 1.5]
    s = m.solve(steps=times)
    names = {name for name, _ in asked}
    assert len(names) == 12
    for name in names:
        assert [t for own, t in asked if own == name] == times
    # what they said is remembered: results ask for nothing new
    asked.clear()
    assert all(np.isfinite(step.bodies["a"].stress).all() for step in s.steps)
    assert not asked


@pytest.mark.parametrize("only", [True, False])
def test_a_stiffness_may_be_a_function(only):
    found = []
    for stiffness in ("1e5*(1 + 0.5*x)", lambda points, t: 1e5 * (1 + 0.5 * points[:, 0])):
        m = dotyk.Model("plane-strain")
        body = m.body("a", dotyk.rectangle([0, 0], [2, 1], cells=[8, 4], cell="quad8"), young=1e8, poisson=0.25)
        body.fix(point=[0, 0], x=0).load("top", pressure="1e4*(2 - x)")
        body.spring("bottom", normal=stiffness, compression_only=only)
        body.spring(point=[2, 1], y=stiffness)
        m.probe("p", "a.bottom.pressure", reduce="max")
        solution = m.solve()
        bed = solution.beds["a.bottom"]
        assert solution.probes["p"].value == solution.probe("a.bottom.pressure", reduce="max")
        assert bed.compression_only is only and abs(bed.area - 2) < 1e-12
        found.append([bed.max_pressure, bed.closed_area, bed.max_gap, *bed.resultant])
    assert np.allclose(*found, rtol=1e-9, atol=1e-12)


def test_a_stiffness_is_the_same_at_all_times():
    def model(stiffness):
        m = dotyk.Model("plane-strain")
        body = m.body("a", dotyk.rectangle([0, 0], [2, 1], cells=[2, 1]), young=1e8, poisson=0.25)
        return body.fix(point=[0, 0], x=0).load("top", pressure=1).spring("bottom", normal=stiffness) and m

    with pytest.raises(dotyk.InputError, match="at all times the same"):
        model(lambda points, t: 1e5 * t + 0 * points[:, 0]).solve()
    with pytest.raises(dotyk.InputError, match="`t` has no meaning here"):
        model("1e5*t")

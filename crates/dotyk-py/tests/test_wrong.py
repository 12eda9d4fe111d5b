"""Wrong calls: an exception of the promised kinds, never a crash."""

from __future__ import annotations

import random

import numpy as np
import pytest

import dotyk

MESH = dotyk.rectangle([0, 0], [1, 1], cells=[2, 2])

VALUES = [
    None, True, -1, 0, 2**70, -1.5, float("nan"), float("inf"), "", "x", "bottom", "top + 1", "a.bottom", "1e6*t",
    b"bytes", [], [1], [0, 0], [0.0, "y"], [[1, 2], [3]], (1, 2, 3), {}, {"side": "top"}, {"a": None}, {1: 2}, object(),
    np.zeros(3), np.zeros((2, 2)), np.array("text"), lambda p, t: None, lambda: 0, MESH, dotyk, Exception("e"), "\x00",
    "\ue0000", "\ud800", range(3), {3}, 1j,
]  # fmt: skip


def model():
    m = dotyk.Model("plane-strain")
    m.body("a", MESH, young=1e6, poisson=0.0).fix("bottom", x=0, y=0).load("top", pressure=1.0)
    return m


CALLS = {
    "model": lambda r, v: dotyk.Model(v(), title=v(), parameters=v()),
    "body": lambda r, v: model().body(v(), r.choice([MESH, v()]), young=v(), poisson=r.choice([0.3, v()])),
    "body_keys": lambda r, v: model().body(
        "b", MESH, young=1.0, poisson=0.0, **{r.choice(["fix", "load", "surface", "points", "active", "strength", "plastic", "hardening"]): v()}
    ),
    "fix": lambda r, v: model().bodies["a"].fix(v(), x=v(), normal=v()),
    "load": lambda r, v: model().bodies["a"].load(r.choice(["top", v()]), traction=v(), pressure=v()),
    "contact": lambda r, v: model().contact("c", nonmortar=v(), mortar=v(), friction=v(), gap=v()),
    "obstacle": lambda r, v: model().contact("c", nonmortar="a.top", obstacle={"gap": v(), "plane": v()}),
    "probe": lambda r, v: model().probe("p", r.choice(["a.stress.xx", v()]), at=v(), along=v(), reduce=v()),
    "step": lambda r, v: model().step(v(), name=v()),
    "solve": lambda r, v: model().solve(
        steps=r.choice([None, v(), [v()]]), method=r.choice([None, v()]), tolerance=r.choice([None, v()]),
        threads=r.choice([None, 1, -1, "two", 2.5]), callback=r.choice([None, 3, "f"]),
    ),
    "mesh": lambda r, v: dotyk.Mesh(v(), {r.choice(["quad4", v_key(v)]): v()}, r.choice([None, v(), {"s": v()}])),
    "rectangle": lambda r, v: dotyk.rectangle(v(), v(), cells=v(), cell=v()),
    "read": lambda r, v: dotyk.read(v(), group=v()),
    "run": lambda r, v: dotyk.run(v(), parameters=v()),
    "study": lambda r, v: dotyk.study(r.choice([model(), v()]), vary=v()),
    "keyword": lambda r, v: model().bodies["a"].fix("top", **{r.choice(["xx", "side", "from", "z"]): v()}),
}  # fmt: skip


def v_key(v):
    value = v()
    return value if isinstance(value, (str, tuple)) else "hex8"


@pytest.mark.parametrize("name", CALLS)
def test_random_wrong_calls_are_refused_and_nothing_crashes(name):
    r = random.Random(name)
    for _ in range(60):
        try:
            CALLS[name](r, lambda: r.choice(VALUES))
        except (dotyk.Error, TypeError):
            pass


def test_solutions_refuse_wrong_questions():
    s = model().solve()
    for wrong in [
        lambda: s.probe("a.stress.qq", at=[0, 0]),
        lambda: s.probe("a.stress.xx"),
        lambda: s.probe("a.stress.xx", at=[9, 9]),
        lambda: s.probe("a.stress.xx", at="here"),
        lambda: s.probe("b.stress.xx", at=[0, 0]),
        lambda: s.probe(3),
        lambda: s.bodies["a"].utilisation,
        lambda: s.plot("nothing"),
        lambda: s.write("/proc/nowhere/at/all"),
        lambda: s.write(3),
        lambda: s.contacts["none"],
        lambda: s.probes["none"],
    ]:
        with pytest.raises((dotyk.Error, TypeError)):
            wrong()

"""Elastic contact mechanics: bodies pressed against each other, with a certificate for every answer.

>>> import dotyk
>>> m = dotyk.Model("plane-strain")
>>> block = m.body("block", dotyk.rectangle([0, 0], [4, 1], cells=[40, 10]), young=210e9, poisson=0.3)
>>> punch = m.body("punch", dotyk.rectangle([1.5, 1], [2.5, 2], cells=[10, 10]), young=210e9, poisson=0.3)
>>> _ = block.fix("bottom", x=0, y=0)
>>> _ = punch.fix("left", x=0).fix("right", x=0).load("top", traction=[0, -1e6])
>>> s = m.contact("sole", nonmortar="punch.bottom", mortar="block.top").solve()
>>> s.converged, round(s.contacts["sole"].resultant[1])
(True, 1000000)
"""

from dotyk import _dotyk
from dotyk._compare import Comparison, Difference, compare
from dotyk._dual import Block, Dual, Problem
from dotyk._errors import ArgumentError, Error, InputError, NotConverged, UnknownName
from dotyk._mesh import (
    Mesh,
    box,
    cylinder,
    drawing,
    extrude,
    outline,
    read,
    rectangle,
    ring,
    sphere,
    tunnel_rock,
)
from dotyk._model import Body, Model
from dotyk._solution import BodySolution, ContactSolution, Figure, Line, Named, ProbeValue, Solution
from dotyk._solve import BodyCheck, Check, ContactCheck, MemberCheck, Progress, Study, check, run, study

__version__: str = _dotyk.version()

__all__ = [
    "ArgumentError",
    "Block",
    "Body",
    "BodyCheck",
    "BodySolution",
    "Check",
    "Comparison",
    "ContactCheck",
    "ContactSolution",
    "Difference",
    "Dual",
    "Error",
    "Figure",
    "InputError",
    "Line",
    "MemberCheck",
    "Mesh",
    "Model",
    "Named",
    "NotConverged",
    "ProbeValue",
    "Problem",
    "Progress",
    "Solution",
    "Study",
    "UnknownName",
    "__version__",
    "box",
    "check",
    "compare",
    "cylinder",
    "drawing",
    "extrude",
    "outline",
    "read",
    "rectangle",
    "ring",
    "run",
    "sphere",
    "study",
    "tunnel_rock",
]

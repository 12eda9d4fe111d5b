"""Small models to try things out on; each call makes a new one, to change and to solve.

>>> import dotyk.examples
>>> dotyk.examples.punch()
<dotyk.Model Punch on a block: plane-strain, bodies block, punch, contacts sole>
"""

from __future__ import annotations

from dotyk._mesh import box, rectangle
from dotyk._model import Model

__all__ = ["boxes", "press_fit", "punch"]


def punch() -> Model:
    """A punch of steel pressed onto a block by 1 MPa; nothing but the contact ``sole`` holds it from below. Metres, newtons.

    >>> import dotyk.examples
    >>> s = dotyk.examples.punch().solve()
    >>> s.converged, round(s.contacts["sole"].resultant[1])
    (True, 1000000)
    """
    m = Model("plane-strain", title="Punch on a block", units={"length": "m", "force": "N"})
    block = m.body("block", rectangle([0, 0], [4, 1], cells=[40, 10]), young=210e9, poisson=0.3)
    punch = m.body("punch", rectangle([1.5, 1], [2.5, 2], cells=[10, 10]), young=210e9, poisson=0.3)
    block.fix("bottom", x=0, y=0)
    punch.fix("left", x=0).fix("right", x=0).load("top", pressure=1e6)
    return m.contact("sole", nonmortar="punch.bottom", mortar="block.top", friction=0.2)


def press_fit() -> Model:
    """A shaft of 50 mm in a hub of 100 mm with an interference of 0.02 mm at the radius, symmetric about its axis;
    friction alone holds the hub. Millimetres, newtons.

    >>> import dotyk.examples
    >>> s = dotyk.examples.press_fit().solve()
    >>> round(s.contacts["fit"].pressure.mean())
    64
    """
    m = Model("axisymmetric", title="Press fit", units={"length": "mm", "force": "N"})
    shaft = m.body("shaft", rectangle([0, 0], [25, 40], cells=[10, 16]), young=210e3, poisson=0.3)
    hub = m.body("hub", rectangle([25, 0], [50, 40], cells=[10, 16]), young=210e3, poisson=0.3)
    shaft.fix("bottom", y=0)
    return m.contact("fit", nonmortar="hub.left", mortar="shaft.right", gap=-0.02, friction=0.15)


def boxes() -> Model:
    """A box on a larger one in space, pressed by 1 MPa. Metres, newtons.

    >>> import dotyk.examples
    >>> s = dotyk.examples.boxes().solve()
    >>> s.bodies["upper"].displacement.shape, round(s.contacts["sole"].resultant[2])
    ((125, 3), 1000000)
    """
    m = Model("3d", title="Box on a box", units={"length": "m", "force": "N"})
    lower = m.body("lower", box([0, 0, 0], [3, 3, 1], cells=[6, 6, 3]), young=210e9, poisson=0.3)
    upper = m.body("upper", box([1, 1, 1], [2, 2, 2], cells=[4, 4, 4]), young=210e9, poisson=0.3)
    lower.fix("bottom", x=0, y=0, z=0)
    upper.fix("top", x=0, y=0).load("top", pressure=1e6)
    return m.contact("sole", nonmortar="upper.bottom", mortar="lower.top")

"""The dual problem: min ½λᵀFλ − dᵀλ over λ ∈ Λ with Gλ = e."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

from dotyk._errors import ArgumentError, InputError, NotConverged
from dotyk._mesh import _frozen
from dotyk._words import friend, unmasked

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from dotyk._solution import Figure, Named, Solution

    Array = npt.NDArray[np.float64]


class Block(NamedTuple):
    """The contact forces of a node.

    >>> import dotyk.examples
    >>> dual = dotyk.examples.punch().dual()
    >>> dual.blocks[0].law, dual.blocks[0].size, dual.blocks[0].coefficient
    ('coulomb', 2, 0.2)
    """

    #: ``"unilateral"``, ``"free"``, ``"tresca"``, ``"coulomb"``, ``"cohesive"`` or ``"interval"``: one force along a line between
    #: −bound and bound.
    law: str
    #: Number of components, the normal one first.
    size: int
    #: Bound of the tangential force, or of that of an interval; NaN where the law has none.
    bound: float
    #: Coefficient of friction; NaN where the law has none.
    coefficient: float


class Problem:
    """F, d, G, e and the blocks of Λ: what a solver of one's own gets.

    gap = F λ − d − Gᵀα, λ in forces, node by node, contacts in the order of the case. A tangential λ pushes the nonmortar body
    against its tangent, as a normal one does: shear = −λ / weight, and a tangential gap is −slip, counted from the last step.

    >>> import dotyk.examples
    >>> dual = dotyk.examples.punch().dual()
    >>> dual.F.shape, dual.d.shape, dual.G.shape, dual.e.shape
    ((22, 22), (22,), (1, 22), (1,))
    """

    def __init__(self, native: Any, product: Callable[[Any], Any] | None = None) -> None:
        self._native, self._product = native, product or native.product

    @cached_property
    def d(self) -> Array:
        """Overlap of the separately loaded bodies (m,).

        >>> import dotyk.examples
        >>> dual = dotyk.examples.punch().dual()
        >>> lam, alpha = dual.solve()
        >>> gap = dual.F @ lam - dual.d - dual.G.T @ alpha
        >>> bool(abs(gap[::2]).max() < 1e-15)
        True
        """
        return _frozen(self._native.d)  # type: ignore[no-any-return]

    @cached_property
    def G(self) -> Array:
        """Balance of the floating bodies (r, m).

        >>> import dotyk.examples
        >>> dual = dotyk.examples.punch().dual()
        >>> lam, alpha = dual.solve()
        >>> bool(abs(dual.G @ lam - dual.e).max() < 1e-3)
        True
        """
        return _frozen(self._native.g)  # type: ignore[no-any-return]

    @cached_property
    def e(self) -> Array:
        """What the contact forces have to balance (r,).

        >>> import dotyk.examples
        >>> dual = dotyk.examples.punch().dual()
        >>> abs(dual.e).round(3).tolist()
        [1000000.0]
        """
        return _frozen(self._native.e)  # type: ignore[no-any-return]

    @cached_property
    def F(self) -> Any:
        """Compliance (m, m): an array up to 2000 unknowns, else a ``scipy.sparse.linalg.LinearOperator``.

        >>> import dotyk.examples
        >>> dual = dotyk.examples.punch().dual()
        >>> bool(abs(dual.F - dual.F.T).max() < 1e-12 * abs(dual.F).max())
        True
        """
        array = self._native.f
        if array is not None:
            return _frozen(array)
        linalg = friend("scipy.sparse.linalg", "F of more than 2000 unknowns")

        def product(x: Any) -> Any:
            made = self._product(_vector(x, "x"))
            if made is None:
                raise InputError("F of this problem can be applied only while the solver that got it is asked")
            return made

        m = len(self.d)
        return linalg.LinearOperator((m, m), matvec=product, rmatvec=product, dtype=float)

    @cached_property
    def blocks(self) -> list[Block]:
        """One for each node, in the order of the unknowns.

        >>> import dotyk.examples
        >>> dual = dotyk.examples.punch().dual()
        >>> len(dual.blocks)
        11
        """
        return [Block(*block) for block in self._native.blocks]

    def __repr__(self) -> str:
        return f"<dotyk.{type(self).__name__}: {len(self.d)} contact forces, {len(self.e)} rigid amplitudes>"


class Dual(Problem):
    """The dual problem of a step of a model, with the way back; made by :meth:`Model.dual`.

    >>> import dotyk
    >>> m = dotyk.Model("plane-strain")
    >>> block = m.body("block", dotyk.rectangle([0, 0], [2, 1], cells=[2, 1]), young=1e9, poisson=0)
    >>> _ = block.load("top", pressure=1e6).fix(point=[0, 0], x=0)
    >>> dual = m.contact("floor", nonmortar="block.bottom", obstacle={"gap": 0.0}).dual()
    >>> dual
    <dotyk.Dual: 3 contact forces, 2 rigid amplitudes>
    >>> lam, alpha = dual.solve("newton")
    >>> float(lam.sum().round())
    2000000.0
    >>> all(figure.holds for figure in dual.certify(lam, alpha).values())
    True
    """

    def __init__(self, native: Any) -> None:
        super().__init__(native.problem(), native.product)
        self._dual = native

    def solve(self, method: str = "auto") -> tuple[Array, Array]:
        """λ (m,) and α (r,) by one of the methods.

        >>> import dotyk.examples
        >>> dual = dotyk.examples.punch().dual()
        >>> lam, alpha = dual.solve("newton")
        >>> round(float(lam[::2].sum()))
        1000000
        """
        if not isinstance(method, str):
            raise ArgumentError("`method` is the name of a method")
        lam, alpha = self._dual.solve(method)
        return lam, alpha

    def certify(self, lam: npt.ArrayLike, alpha: npt.ArrayLike) -> Named[Figure]:
        """The certificate of contact forces, whoever has found them.

        >>> import dotyk.examples
        >>> dual = dotyk.examples.punch().dual()
        >>> lam, alpha = dual.solve()
        >>> dual.certify(1.01 * lam, alpha)["imbalance_force"].holds
        False
        """
        from dotyk._solution import Figure, Named

        figures = self._dual.certify((_vector(lam, "lam"), _vector(alpha, "alpha")))
        return Named("figure", {name: Figure(*figure) for name, figure in figures.items()})

    def recover(self, lam: npt.ArrayLike, alpha: npt.ArrayLike) -> Solution:
        """The solution of contact forces; :class:`NotConverged` with it where its certificate does not hold.

        >>> import dotyk.examples
        >>> dual = dotyk.examples.punch().dual()
        >>> dual.recover(*dual.solve()).converged
        True
        """
        from dotyk._solution import Solution

        run = self._dual.recover((_vector(lam, "lam"), _vector(alpha, "alpha")))
        solution = Solution._of(run)
        if run.failure is not None:
            raise NotConverged(run.failure[0], solution)
        return solution


def own_solver(solver: Callable[[Problem], Any]) -> Callable[[Any], Any]:
    """A solver of the user as the library calls it."""

    def answer(native: Any) -> Any:
        given = solver(Problem(native))
        try:
            lam, alpha = given
        except (TypeError, ValueError):
            raise InputError("a solver of one's own gives (lam, alpha)") from None
        return _vector(lam, "lam"), _vector(alpha, "alpha")

    return answer


def _vector(values: Any, name: str) -> Any:
    import numpy as np

    unmasked(values, f"`{name}`")
    try:
        array = np.ascontiguousarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise ArgumentError(f"`{name}` is an array of numbers") from None
    return array.ravel() if array.ndim != 1 else array

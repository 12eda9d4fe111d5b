"""Every call of the contract as a typed program writes it: never run, but read by the type checker beside the installed package."""

from pathlib import Path
import numpy as np
import numpy.typing as npt
import dotyk
import dotyk.examples

Points = npt.NDArray[np.float64]

def push(points: Points, t: float) -> Points:
    return np.column_stack([np.zeros(len(points)), -1e6 * t * points[:, 0]])


def program() -> None:
    s = dotyk.run("case.toml", parameters={"E": 3e9}, method=None, threads=None)
    s = dotyk.run(Path("case.toml"))
    m = dotyk.Model("plane-strain", title="a", units={"length": "m", "force": "N"}, parameters={"E": 1.0})
    rock = m.body("rock", dotyk.read("part.msh", group="rock"), young=2e9, poisson=0.25)
    rock = m.body("r2", dotyk.Mesh(np.zeros((4, 2)), {"quad4": np.zeros((1, 4), int)}, {"top": [[0, 1]]}), young="E", poisson=0.25)
    rock.fix("bottom", x=0, y=0); rock.load("top", traction=[0, "-1e6*t"]); rock.fix(point=[0, 1], x=0)
    rock.load("top", traction=push).load("top", pressure=lambda p, t: p[:, 0])
    rock.body_force([0, -1]).initial_stress(vertical="-1*y", k0=0.5).spring("bottom", normal=1e6)
    m.contact("gamma", nonmortar="rock.hole", mortar="lining.outer", friction=0.3)
    m.contact("g2", nonmortar="rock.hole", obstacle={"gap": lambda p, t: p[:, 0]}, friction={"coulomb": 0.3, "cohesion": 1.0})
    m.bar("b", from_=[0, 0], to=[1, 1], young=1.0, area=1.0, yield_=3.0)
    m.bar("b", **{"from": [0, 0], "to": [1, 1], "young": 1.0, "area": 1.0, "yield": 3.0})  # type: ignore[arg-type]
    m.spring("k", from_=[0, 0], to=[1, 1], bodies=["rock"], stiffness=1.0, acts="compression", gap=0.1)
    m.bolt("m20", body="rock", at=[0, 1], axis=[0, 1], prestress="40e3*t", tightened={"until": 2.0})
    m.section("s", body="rock", sides=["a", "b"], stations=8).probe("p", "rock.stress.xx", at=[0, 1]).step(0.5, name="a")
    s = m.solve(steps=[0.5, 1.0], method="newton", tolerance=1e-8, max_iterations=None, threads=None, callback=None)
    ok: bool = s.converged
    v: float = s.certificate["penetration"].relative
    u: Points = s.bodies["rock"].displacement
    p: Points = s.contacts["gamma"].pressure
    x: float = s.probe("rock.stress.xx", at=[0, 1]); m.probe("half", expression="p/2")
    most: float = s.probe("rock.stress.xx", along="rock.top", reduce="max")
    half: float = s.probe(expression="p/2")
    line: Points = s.probe("rock.stress.xx", along="rock.top").values
    y: float = s.probes["name"]
    t: float = s.steps[0].time
    s.contacts["gamma"].to_pandas(); s.bodies["rock"].to_meshio(); s.to_pyvista(); s.plot(); s.report("report.html"); s.write("out"); s.write(Path("o"))
    d = m.dual()
    d.F, d.d, d.G, d.e, d.blocks
    lam, alpha = d.solve("newton")
    d.certify(lam, alpha); d.recover(lam, alpha)
    def my_solver(dual: dotyk.Problem) -> tuple[Points, Points]:
        return np.zeros(len(dual.d)), np.zeros(len(dual.e))
    m.solve(method=my_solver)
    def of_dual(dual: dotyk.Dual) -> tuple[Points, Points]:
        return np.zeros(len(dual.d)), np.zeros(len(dual.e))
    m.solve(method=of_dual)
    r = dotyk.check("case.toml"); m = dotyk.Model.from_case("case.toml")
    print(r.errors, r.warnings, r.bodies["rock"].floating, r.members["b"].length)
    st = dotyk.study("case.toml", vary={"E": np.linspace(0, 1, 3), "q": [1.0]}, steps="all")
    n: int = len(st); st.to_pandas()
    def cb(progress: dotyk.Progress) -> None:
        print(progress.stage, progress.step, progress.iteration, progress.measure)
    m.solve(callback=cb)
    try:
        m.solve()
    except dotyk.NotConverged as e:
        print(e.solution.contacts, e.solution.failed_step)
    print(s.bodies["rock"].reaction, s.contacts["g"].resultant, s.sections["s"], s.beds["rock.top"].max_pressure, s.bars["b"].force, s.springs["k"].force, s.bolts["m20"].shortening, s.units, s.warnings[0], s.seconds["total"])
    small = dotyk.examples.punch().solve()
    mesh = dotyk.rectangle([0, 0], [4, 1], cells=[80, 20]); dotyk.ring(1, 2, cells=[3, 4]); dotyk.extrude(mesh, height=-1, offset=2.5, layers=2)
    dotyk.rectangle(from_=[0, 0], to=[1, 1], cells=(1, 1)); dotyk.outline(size=1.0, from_=[0, 0], edges=[])
    dotyk.rectangle(np.zeros(2), np.ones(2), cells=np.array([1, 1]))

"""What the interface promises, by small problems whose answers are known."""

from __future__ import annotations

import pickle
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import dotyk
import dotyk.examples

CASES = Path(__file__).resolve().parents[3] / "cases"


def column(load, analysis="plane-strain"):
    """A column on a rigid floor: pressure p gives the stress −p everywhere."""
    m = dotyk.Model(analysis)
    if analysis == "3d":
        body = m.body("a", dotyk.box([0, 0, 0], [1, 1, 2], cells=[2, 2, 2]), young=1e9, poisson=0.0)
        body.fix(point=[0, 0, 0], x=0, y=0).fix(point=[1, 0, 0], y=0)
    else:
        body = m.body("a", dotyk.rectangle([0, 0], [1, 2], cells=[2, 4]), young=1e9, poisson=0.0)
        body.fix(point=[0, 0], x=0)
    body.load("top", **load)
    m.contact("floor", nonmortar="a.bottom", obstacle={"gap": 0.0})
    return m


def punch(cells=10, **contact):
    m = dotyk.Model("plane-strain")
    block = m.body("block", dotyk.rectangle([0, 0], [4, 1], cells=[4 * cells, cells]), young=210e9, poisson=0.3)
    top = m.body("punch", dotyk.rectangle([1.5, 1], [2.5, 2], cells=[cells, cells]), young=210e9, poisson=0.3)
    block.fix("bottom", x=0, y=0)
    top.fix("left", x=0).fix("right", x=0).load("top", traction=[0, "-1e6*t"])
    m.contact("sole", nonmortar="punch.bottom", mortar="block.top", **contact)
    return m


def test_a_deck_is_run_as_a_case_is(tmp_path):
    deck = CASES.parent / "crates" / "dotyk-cli" / "tests" / "decks" / "press.inp"
    s = dotyk.run(deck)
    assert s.converged and list(s.contacts) == ["Upper-Lower"]
    high = s.bodies["High"]
    assert high.displacement[:, 2].min() == pytest.approx(-0.02, abs=1e-12)
    assert list(dotyk.check(deck).bodies) == ["Low", "High"]
    with pytest.raises(dotyk.InputError, match="a deck has no parameter `E`"):
        dotyk.run(deck, parameters={"E": 3e9})
    with pytest.raises(dotyk.InputError, match="dotyk import"):
        dotyk.Model.from_case(deck)
    wrong = tmp_path / "wrong.inp"
    wrong.write_text("*NODE\n1, 0, 0\n*ELEMENT\n")
    with pytest.raises(dotyk.InputError, match="wrong.inp, line 3, column 1: \\*ELEMENT: TYPE is missing"):
        dotyk.run(wrong)


def test_a_case_file_gives_what_the_command_gives(tmp_path):
    case = CASES / "floating-punch" / "floating-punch.toml"
    if not case.exists():
        case = next((CASES / "floating-punch").glob("*.toml"))
    s = dotyk.run(case)
    from dotyk import _dotyk

    out = tmp_path / "out"
    assert _dotyk.command(["dotyk", "run", str(case), "--out", str(out), "--quiet"]) == 0
    import json

    told = json.loads((out / "summary.json").read_text())
    for contact in told["contacts"]:
        assert s.contacts[contact["name"]].resultant == contact["resultant"]
    assert s.case == told["case"] and s.iterations == told["iterations"]
    assert set(told) <= set(dir(s))


def test_steps_are_solutions_with_their_times():
    s = column({"pressure": "1e6*t"}).solve(steps=[0.5, ("full", 1.0)])
    assert [step.time for step in s.steps] == [0.5, 1.0]
    assert s.steps[-1] is s and s.name == "full"
    assert s.steps[0].contacts["floor"].resultant[1] == pytest.approx(0.5e6)
    assert s.probe("a.stress.yy", at=[0.5, 1.0]) == pytest.approx(-1e6)
    assert s.steps[0].probe("a.stress.yy", at=[0.5, 1.0]) == pytest.approx(-0.5e6)


@pytest.mark.parametrize("analysis", ["plane-strain", "3d"])
def test_functions_are_called_once_for_each_step_with_all_points(analysis):
    calls = []

    def traction(points, t):
        calls.append((points.shape, t, threading.get_ident()))
        out = np.zeros_like(points)
        out[:, -1] = -1e6 * t
        return out

    s = column({"traction": traction}, analysis).solve(steps=[0.5, 1.0])
    assert s.contacts["floor"].resultant[-1] == pytest.approx(1e6)
    assert [t for _, t, _ in calls] == [0.5, 1.0]
    assert all(shape[0] > 1 for shape, _, _ in calls)
    assert {thread for _, _, thread in calls} == {threading.get_ident()}


def test_functions_stand_for_gaps_friction_supports_and_forces_within():
    calls = {"gap": [], "friction": [], "lift": [], "weight": []}

    def constant(name, value):
        def f(points, t):
            calls[name].append(t)
            return np.full(len(points), value * t)

        return f

    def weight(points, t):
        calls["weight"].append(t)
        return np.column_stack([np.zeros(len(points)), np.full(len(points), -1e3)])

    m = dotyk.Model("plane-strain")
    m.body("a", dotyk.rectangle([0, 0], [1, 2], cells=[2, 4]), young=1e9, poisson=0.0, body_force=weight).fix(
        "top", x=0, y=constant("lift", -1e-3)
    )
    m.contact("floor", nonmortar="a.bottom", obstacle={"gap": constant("gap", 5e-4)}, friction=constant("friction", 0.3))
    s = m.solve(steps=[1.0, 2.0])
    # half of the way is free
    assert s.contacts["floor"].resultant[1] == pytest.approx(2 * 5e-4 / 2 * 1e9 + 1e3, rel=1e-6)
    for name in calls:
        assert calls[name] == [1.0, 2.0], (name, calls[name])


def test_what_a_function_gives_is_checked():
    with pytest.raises(dotyk.InputError, match=r"body `a`.*shape \(\d+, 2\)"):
        column({"traction": lambda p, t: np.zeros(len(p))}).solve()
    with pytest.raises(dotyk.InputError, match="finite"):
        column({"pressure": lambda p, t: np.full(len(p), np.nan)}).solve()

    class Own(Exception):
        pass

    def raises(points, t):
        raise Own("mine")

    m = column({"pressure": raises})
    with pytest.raises(Own, match="mine"):
        m.solve()
    with pytest.raises(Own):
        column({"pressure": 1.0}).solve(callback=lambda told: (_ for _ in ()).throw(Own()))


def test_the_callback_is_told_of_stages_steps_and_iterations():
    told = []
    punch().solve(steps=[0.5, 1.0], callback=told.append)
    assert {p.step for p in told} == {1, 2}
    assert {"step", "assemble", "contact", "recover"} <= {p.stage for p in told}
    assert any(p.iteration > 0 and p.measure >= 0 for p in told)


def test_errors_are_of_the_promised_kinds():
    m = dotyk.Model("plane-strain")
    mesh = dotyk.rectangle([0, 0], [1, 1], cells=[2, 2])
    with pytest.raises(TypeError, match="young"):
        m.body("a", mesh, yuong=1.0, poisson=0.3)
    with pytest.raises(ValueError, match="positive"):
        m.body("a", mesh, young=-1.0, poisson=0.3)
    body = m.body("a", mesh, young=1.0, poisson=0.3)
    with pytest.raises(dotyk.InputError, match="`bottom`"):
        body.fix("botom", x=0)
    with pytest.raises(dotyk.InputError):
        m.contact("c", nonmortar="a.top", mortar="b.top")
    with pytest.raises(TypeError):
        m.contact("c", nonmortar="a.top", morta="b.top")
    with pytest.raises(dotyk.InputError, match="no-such"):
        dotyk.run("no-such.toml")
    with pytest.raises(dotyk.InputError):
        dotyk.Model("plane-strian")
    s = column({"pressure": 1.0}).solve()
    with pytest.raises(KeyError, match="floor"):
        s.contacts["flor"]
    with pytest.raises(dotyk.InputError):
        s.bodies["b"]
    assert issubclass(dotyk.InputError, ValueError) and issubclass(dotyk.NotConverged, RuntimeError)


def test_what_slides_away_is_refused_and_what_friction_cannot_hold_is_not_converged():
    m = dotyk.Model("plane-strain")
    body = m.body("a", dotyk.rectangle([0, 0], [1, 1], cells=[2, 2]), young=1e6, poisson=0.0)
    body.load("top", traction=[0.4, -1.0])
    m.contact("floor", nonmortar="a.bottom", obstacle={"gap": 0.0}, friction=0.3)
    with pytest.raises(dotyk.NotConverged) as caught:
        m.solve()
    assert caught.value.solution is not None and not caught.value.solution.converged
    with pytest.raises(dotyk.NotConverged):
        punch().solve(method="gradient", max_iterations=2)


def test_arrays_are_read_only_and_solutions_never_change():
    s = punch().solve()
    array = s.contacts["sole"].pressure
    with pytest.raises(ValueError):
        array[0] = 1.0
    with pytest.raises(AttributeError):
        s.converged = False
    del s
    assert np.isfinite(array).all()


def test_the_callers_arrays_stay_the_callers():
    points = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], dtype=np.float32)
    cells = np.asfortranarray(np.array([[0, 1, 2, 3]], dtype=np.uint8))
    mesh = dotyk.Mesh(points, {"quad4": cells}, {"bottom": np.array([[1, 0]], dtype=np.int16)})
    points[:] = 7
    assert mesh.points.max() == 1.0 and mesh.points.dtype == np.float64
    assert sorted(mesh.sides["bottom"][0]) == [0, 1]


def test_solutions_meshes_and_errors_pickle():
    m = punch()
    s = m.solve(steps=[0.5, 1.0])
    t = pickle.loads(pickle.dumps(s))
    assert np.array_equal(s.contacts["sole"].pressure, t.contacts["sole"].pressure)
    assert np.array_equal(s.steps[0].bodies["punch"].stress, t.steps[0].bodies["punch"].stress)
    assert len(t.report()) == len(s.report()) or "NaN" not in t.report()
    mesh = pickle.loads(pickle.dumps(dotyk.rectangle([0, 0], [1, 1], cells=[2, 2])))
    assert mesh.sides.keys() == {"left", "right", "bottom", "top"}
    for error in (dotyk.InputError("a"), dotyk.NotConverged("b", s), dotyk.UnknownName("c")):
        again = pickle.loads(pickle.dumps(error))
        assert type(again) is type(error) and str(again) == str(error)


def test_the_dual_problem_goes_out_and_back():
    m = punch()
    d = m.dual()
    s = m.solve()
    assert d.F.shape == (len(d.d), len(d.d)) and np.allclose(d.F, d.F.T)
    assert [b.law for b in d.blocks] == ["unilateral"] * len(d.blocks)
    lam, alpha = d.solve("newton")
    assert np.allclose(d.G @ lam, d.e)
    gap = d.F @ lam - d.d - d.G.T @ alpha
    contact = s.contacts["sole"]
    carry = contact.status != "fixed"
    assert np.allclose(lam / contact.weight[carry], contact.pressure[carry], rtol=1e-6)
    assert np.allclose(gap, contact.gap[carry], atol=1e-9 * abs(d.d).max())
    assert all(figure.holds for figure in d.certify(lam, alpha).values())
    assert d.recover(lam, alpha).converged
    with pytest.raises(dotyk.NotConverged) as caught:
        d.recover(0.5 * lam, alpha)
    assert caught.value.solution.certificate["imbalance_force"].relative > 0.1


def test_an_own_solver_is_judged():
    m = punch()

    def bilateral(p):
        n, r = len(p.d), len(p.e)
        # lengths and forces are far from each other in size
        scale = abs(p.F).max()
        matrix = np.block([[p.F / scale, -p.G.T], [p.G, np.zeros((r, r))]])
        x = np.linalg.solve(matrix, np.concatenate([p.d / scale, p.e]))
        return x[:n], x[n:] * scale

    # all nodes of a flat punch stay closed: the bilateral answer is the answer
    s = m.solve(method=bilateral)
    assert s.converged and s.solver == "own"
    with pytest.raises(dotyk.NotConverged):
        m.solve(method=lambda p: (np.zeros(len(p.d)), np.zeros(len(p.e))))
    with pytest.raises(dotyk.InputError):
        m.solve(method=lambda p: 3)


def test_threads_change_no_bit_and_models_are_solved_side_by_side():
    m = punch(16, friction=0.3)
    one = m.solve(threads=1).bodies["punch"].displacement
    assert np.array_equal(one, m.solve(threads=2).bodies["punch"].displacement)
    with ThreadPoolExecutor(4) as pool:
        for s in pool.map(lambda _: m.solve(), range(8)):
            assert np.array_equal(one, s.bodies["punch"].displacement)


def test_a_study_has_all_combinations():
    m = dotyk.Model("plane-strain", parameters={"E": 1e9, "p": 1e6})
    body = m.body("a", dotyk.rectangle([0, 0], [1, 2], cells=[2, 4]), young="E", poisson=0.0)
    body.fix("bottom", x=0, y=0).load("top", pressure="p")
    m.probe("u", "a.displacement.y", at=[0.5, 2.0])
    t = dotyk.study(m, vary={"E": np.array([1e9, 2e9, 4e9]), "p": [1e6, 2e6]})
    assert len(t) == 6 and t.converged
    assert np.allclose(t["u"], -t["p"] * 2.0 / t["E"])
    with pytest.raises(dotyk.InputError, match="`E`"):
        dotyk.study(m, vary={"EE": [1.0]})
    with pytest.raises(KeyError):
        t["v"]


def test_from_case_goes_on_from_a_file():
    case = next((CASES / "floating-punch").glob("*.toml"))
    m = dotyk.Model.from_case(case)
    s, t = m.solve(), dotyk.run(case)
    for name in t.contacts:
        assert np.array_equal(s.contacts[name].pressure, t.contacts[name].pressure)


def test_every_case_file_is_read_as_a_model():
    for folder in sorted(CASES.iterdir()):
        for case in sorted(folder.glob("*.toml")) if folder.is_dir() else []:
            if case.name != "reference.toml":
                m = dotyk.Model.from_case(case)
                # what was read is written again word for word
                assert m._case(m._document(), m._solver).stem == case.stem


def test_check_tells_what_floats():
    r = punch().check()
    assert not r.errors and "translation along y" in " ".join(r.bodies["punch"].floating)
    broken = dotyk.Model("plane-strain")
    broken.body("a", dotyk.rectangle([0, 0], [1, 1], cells=[2, 2]), young=1.0, poisson=0.0).load("top", pressure=1.0)
    assert broken.check().errors


def test_files_are_those_of_the_command(tmp_path):
    files = {Path(f).name for f in punch().solve().write(tmp_path / "out")}
    assert {"report.html", "summary.json", "contact.csv", "block.vtu", "punch.vtu", "case.pvd"} <= files
    s = punch().solve()
    assert s.report(tmp_path / "r.html").startswith("<!DOCTYPE html>")
    with pytest.raises(dotyk.InputError, match="cannot write"):
        s.report(tmp_path)
    html = s._repr_html_()
    assert "http://" not in html.replace("http://www.w3.org", "") and "<svg" in html


def test_ctrl_c_ends_the_wait_within_a_second():
    code = (
        "import dotyk, _thread, threading, time\n"
        "m = dotyk.Model('3d')\n"
        "b = m.body('a', dotyk.box([0,0,0],[1,1,1],cells=[45,45,45]), young=1.0, poisson=0.3)\n"
        "b.fix('bottom', x=0, y=0, z=0).load('top', pressure=1.0)\n"
        "start = [0.0]\n"
        "def stop():\n"
        "    time.sleep(0.7); start[0] = time.monotonic(); _thread.interrupt_main()\n"
        "threading.Thread(target=stop, daemon=True).start()\n"
        "try:\n"
        "    m.solve()\n"
        "except KeyboardInterrupt:\n"
        "    took = time.monotonic() - start[0]\n"
        "    small = dotyk.Model('plane-strain')\n"
        "    small.body('a', dotyk.rectangle([0,0],[1,1],cells=[2,2]), young=1.0, poisson=0.0).fix('bottom', x=0, y=0)\n"
        "    print('took', took, small.solve().converged, flush=True)\n"
        "    import os; os._exit(0)\n"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=False)
    word, took, usable = out.stdout.split()
    assert float(took) < 1.0 and usable == "True"


def test_importing_is_quick_and_needs_no_friend():
    code = "import sys, dotyk; print([n for n in ('numpy','scipy','pandas','matplotlib','meshio','pyvista') if n in sys.modules])"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "[]"


def test_the_lock_is_free_while_solving():
    m = punch(40)
    ticks, stop = [], threading.Event()

    def tick():
        while not stop.is_set():
            ticks.append(time.monotonic())
            time.sleep(0.002)

    thread = threading.Thread(target=tick)
    thread.start()
    m.solve()
    stop.set()
    thread.join()
    assert max(np.diff(ticks), default=0.0) < 0.2


def test_the_command_comes_with_the_package(tmp_path):
    case = next((CASES / "floating-punch").glob("*.toml"))
    out = subprocess.run([sys.executable, "-m", "dotyk", "check", str(case)], capture_output=True, text=True, check=False)
    assert out.returncode == 0 and "punch" in out.stdout
    out = subprocess.run([sys.executable, "-m", "dotyk", "run", "none.toml"], capture_output=True, text=True, check=False)
    assert out.returncode == 2 and "none.toml" in out.stderr


def test_lists_may_hold_functions_component_by_component():
    s = column({"traction": [0, lambda points, t: np.full(len(points), -2e6 * t)]}).solve(steps=[0.5])
    assert s.contacts["floor"].resultant[1] == pytest.approx(1e6)


def test_large_dual_problems_have_an_operator_and_own_solvers_apply_it():
    linalg = pytest.importorskip("scipy.sparse.linalg")
    m = dotyk.Model("plane-strain")
    body = m.body("a", dotyk.rectangle([0, 0], [2100, 1], cells=[2100, 1]), young=1e6, poisson=0.0)
    body.fix("top", x=0, y="-1e-3*t")
    m.contact("floor", nonmortar="a.bottom", obstacle={"gap": 0.0})
    d = m.dual()
    assert len(d.d) > 2000 and isinstance(d.F, linalg.LinearOperator)
    lam, alpha = d.solve("newton")
    contact = m.solve().contacts["floor"]
    assert np.allclose(lam / contact.weight, contact.pressure)
    kept = []

    def closed(p):
        kept.append(p)
        x, info = linalg.cg(p.F, p.d, rtol=1e-13)
        assert info == 0
        return x, np.zeros(0)

    s = m.solve(method=closed)
    assert np.allclose(s.contacts["floor"].pressure, contact.pressure, rtol=1e-6)
    with pytest.raises(dotyk.InputError, match="while"):
        kept[0].F @ kept[0].d


def test_meshes_go_to_meshio_and_back_with_sides_groups_and_fields():
    meshio = pytest.importorskip("meshio")
    s = punch().solve()
    there = s.bodies["punch"].to_meshio()
    assert {"displacement", "stress", "von_mises", "pressure", "gap", "contact_state"} <= set(there.point_data)
    m = dotyk.Model("plane-strain")
    body = m.body("again", there, young=1.0, poisson=0.0)
    assert set(body.mesh.sides) >= {"left", "right", "top", "bottom"}
    assert np.array_equal(body.mesh.points, s.bodies["punch"].points)
    tagged = meshio.Mesh(
        [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]],
        [("quad", [[0, 1, 2, 3]]), ("line", [[0, 1]])],
        cell_data={"gmsh:physical": [np.array([7]), np.array([3])]},
        field_data={"rock": np.array([7, 2]), "floor": np.array([3, 1])},
    )
    mesh = dotyk.Model("plane-strain").body("a", tagged, material=[{"young": 1.0, "poisson": 0.0, "group": "rock"}]).mesh
    assert list(mesh.cells) == [("quad4", "rock")] and set(mesh.sides) == {"boundary", "floor"}


def test_pictures_and_tables_come_from_friends():
    pytest.importorskip("matplotlib").use("Agg")
    s = punch().solve()
    assert len(s.plot().axes) >= 3
    solution = column({"pressure": 1.0}, "3d").solve()
    figure = solution.plot(scale=0.0)
    # bodies, pressure and gap of the contact, each with its colours
    assert len(figure.axes) == 6
    # all bodies in one picture, within its limits
    points = np.vstack([body.points for body in solution.bodies.values()])
    for k, limits in enumerate([figure.axes[0].get_xlim(), figure.axes[0].get_ylim(), figure.axes[0].get_zlim()]):
        assert limits[0] <= points[:, k].min() and points[:, k].max() <= limits[1]
    assert len(figure.axes[0].collections) == 1
    table = s.contacts["sole"].to_pandas()
    assert np.allclose(table["pressure"], s.contacts["sole"].pressure) and set(table["step"]) == {1}


def test_what_a_call_was_given_may_change_afterwards():
    traction, stress = np.array([0.0, -1e6]), {"xx": 0.0, "yy": 0.0, "zz": 0.0}
    m = column({"traction": traction})
    m.bodies["a"].initial_stress(**stress)
    body = m.body("b", dotyk.rectangle([5, 0], [6, 1], cells=[1, 1]), young=1.0, poisson=0.0, initial_stress=stress)
    body.fix("bottom", x=0, y=0)
    traction[:] = 0
    stress["yy"] = -5.0
    s = m.solve()
    assert s.contacts["floor"].resultant[1] == pytest.approx(1e6)
    assert s.bodies["b"].max_displacement < 1e-12


def test_names_like_numbers_or_missing_values_keep_their_rows():
    for name in ("007", "1e3", "NA", "nan", "True"):
        m = dotyk.Model("plane-strain")
        m.body("a", dotyk.rectangle([0, 0], [1, 1], cells=[2, 2]), young=1e6, poisson=0.0).load("top", pressure=1.0).fix(
            point=[0, 0], x=0
        )
        s = m.contact(name, nonmortar="a.bottom", obstacle={"gap": 0.0}).solve()
        assert len(s.contacts[name].to_pandas()) == len(s.contacts[name].node) == 3


def test_as_many_cells_as_nodes_make_no_fields_of_cells():
    m = dotyk.Model("plane-strain")
    m.body("r", dotyk.ring(1, 2, cells=[16, 1], cell="tri3"), young=1.0, poisson=0.0).fix("inner", x=0, y=0)
    fields = m.solve().bodies["r"].to_meshio().point_data
    assert "offsets" not in fields and "types" not in fields and "displacement" in fields


def test_sides_with_facets_of_two_kinds_come_back_from_meshio():
    plane = dotyk.Mesh(
        [[0, 0], [1, 0], [1, 1], [0, 1], [2, 0]], {"quad4": [[0, 1, 2, 3]], "tri3": [[1, 4, 2]]}, {"bottom": [[0, 1], [1, 4]]}
    )
    solid = dotyk.extrude(plane, height=1, layers=1)
    again = dotyk.Model("3d").body("x", solid.to_meshio(), young=1.0, poisson=0.0).mesh
    assert set(again.sides) == {"bottom", "boundary", "first", "last"}


def test_wrong_meshes_of_meshio_are_refused():
    meshio = pytest.importorskip("meshio")
    points = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]]
    wrong = [
        ({"quad": [[0, 1, 2, -1]]}, points, {}),
        ({"quad": [[0, 1, 2, 9]]}, points, {}),
        ({"quad": np.array([[0, 1, 2.5, 3]])}, points, {}),
        ({"quad": [[0, 1, 2, 3]]}, [[*p[:2], 5.0 * p[0]] for p in points], {}),
        ({"quad": [[0, 1, 2, 3]]}, points, {"s": [np.array([4])]}),
    ]
    for cells, at, sets in wrong:
        with pytest.raises((dotyk.InputError, TypeError)):
            dotyk.Model("plane-strain").body("z", meshio.Mesh(at, cells, cell_sets=sets), young=1.0, poisson=0.0)


def test_cells_of_kinds_that_are_not_known_are_refused_with_kind_and_count():
    meshio = pytest.importorskip("meshio")
    points = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1], [0.5, 0.5, 2.0]]
    cells = [("hexahedron", [[0, 1, 2, 3, 4, 5, 6, 7]]), ("pyramid", [[4, 5, 6, 7, 8]])]
    with pytest.raises(dotyk.InputError, match="1 `pyramid`"):
        dotyk.Model("3d").body("b", meshio.Mesh(points, cells), young=1.0, poisson=0.0)
    with pytest.raises(dotyk.InputError, match="1 `pyramid`"):
        dotyk.Model("3d").body("b", meshio.Mesh(points, cells[1:]), young=1.0, poisson=0.0)
    third = [[0, 0], [1, 0], [1, 1], [0, 1], [1, 1 / 3], [1, 2 / 3], [2 / 3, 1], [1 / 3, 1], [2 / 3, 2 / 3], [1 / 3, 1 / 3]]
    plane = meshio.Mesh(third, [("quad", [[0, 1, 2, 3]]), ("triangle10", [[0, 1, 2, 9, 8, 4, 5, 6, 7, 3], [0, 2, 3, 9, 8, 4, 5, 6, 7, 1]])])
    with pytest.raises(dotyk.InputError, match="2 `triangle10`"):
        dotyk.Model("plane-strain").body("b", plane, young=1.0, poisson=0.0)


def test_cells_that_are_listed_twice_count_once():
    points, square = [[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 1, 2], [0, 2, 3]]
    twice = dotyk.Mesh(points, {("tri3", "a"): [*square, [2, 0, 1]], ("tri3", "b"): square}, {"bottom": [[0, 1]]})
    assert twice.warnings == ["3 repeated cells are left out"] and list(twice.cells) == [("tri3", "a")]
    m = dotyk.Model("plane-strain")
    m.body("b", twice, young=1e3, poisson=0.0).fix("bottom", x=0, y=0).body_force([0, -1.0])
    assert m.solve().bodies["b"].reaction[1] == pytest.approx(1.0)
    meshio = pytest.importorskip("meshio")
    tags = {"gmsh:physical": [np.array([1, 1, 2, 2])]}
    names = {"low": np.array([1, 2]), "all": np.array([2, 2])}
    mesh = meshio.Mesh(points, [("triangle", square + square)], cell_data=tags, field_data=names)
    cells = dotyk.Model("plane-strain").body("b", mesh, young=1.0, poisson=0.0).mesh.cells
    assert {key: len(own) for key, own in cells.items()} == {("tri3", "low"): 2}


def test_parts_that_are_not_glued_are_told_with_the_place():
    points = [[0, 0], [1, 0], [1, 1], [0, 1], [0, 1], [1, 1], [1, 2], [0, 2]]
    mesh = dotyk.Mesh(points, {"quad4": [[0, 1, 2, 3], [4, 5, 6, 7]]}, {"bottom": [[0, 1]], "top": [[6, 7]]})
    m = dotyk.Model("plane-strain")
    m.body("b", mesh, young=1e3, poisson=0.0).fix("bottom", x=0, y=0).fix("top", x=0, y=0)
    assert any("without common nodes" in told and "(0.5, 1)" in told for told in m.solve().warnings)


def test_between_materials_nodes_have_the_stress_of_the_one_that_is_stressed_most():
    mesh = dotyk.Mesh(
        [[0, 0], [1, 0], [2, 0], [0, 1], [1, 1], [2, 1]], {("quad4", "soft"): [[0, 1, 4, 3]], ("quad4", "stiff"): [[1, 2, 5, 4]]}
    )
    m = dotyk.Model("plane-stress")
    material = [{"group": "soft", "young": 1.0, "poisson": 0}, {"group": "stiff", "young": 100.0, "poisson": 0}]
    body = m.body("b", mesh, material=material)
    for x in (0, 1, 2):
        for y in (0, 1):
            body.fix(point=[x, y], x=0.01 * x, y=0)
    s = m.solve().bodies["b"]
    assert np.allclose(s.stress[:, 0], [0.01, 1, 1, 0.01, 1, 1]) and s.von_mises.max() == s.max_von_mises
    assert np.allclose(s.strain[:, 0], 0.01) and np.allclose(s.principal_stress[:, 0], s.stress[:, 0])
    fields = s._fields()
    assert all(len(values) == 6 for values in fields.values()) and np.array_equal(fields["stress"], s.stress)


def test_names_of_the_user_keep_their_underscores():
    m = dotyk.Model("plane-strain", parameters={"lambda_": 1e6})
    body = m.body("a", dotyk.rectangle([0, 0], [1, 2], cells=[2, 4]), young=1e9, poisson=0.0)
    body.fix("bottom", x=0, y=0).load("top", pressure="lambda_").points(is_=[1, 2]).load(point="is_", force=[1, 0])
    assert m.solve().bodies["a"].reaction[1] == pytest.approx(1e6)


def test_threads_beyond_reason_are_refused_and_nothing_of_a_solution_changes():
    m = punch()
    with pytest.raises(dotyk.InputError, match="threads"):
        m.solve(threads=10_000)
    s = m.solve()
    array = s.bodies["punch"].displacement
    with pytest.raises(ValueError):
        array.flags.writeable = True
    with pytest.raises(AttributeError):
        s.warnings.append("x")
    with pytest.raises(AttributeError):
        s.contacts["sole"].resultant.append(1.0)
    contact, body = pickle.loads(pickle.dumps((s.contacts["sole"], s.bodies["punch"])))
    assert np.array_equal(contact.gap, s.contacts["sole"].gap) and body.dofs == s.bodies["punch"].dofs
    with pytest.raises(dotyk.NotConverged):
        m.solve(method=lambda p: (np.full(len(p.d), np.nan), np.zeros(len(p.e))))


def test_a_solution_stays_usable_after_an_interrupted_call():
    m = dotyk.Model("plane-strain")
    body = m.body("a", dotyk.rectangle([0, 0], [1, 1], cells=[200, 200]), young=1.0, poisson=0.3)
    s = body.fix("bottom", x=0, y=0).load("top", pressure=1.0) and m.solve()
    import _thread

    timer = threading.Timer(0.02, _thread.interrupt_main)
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        for _ in range(1000):
            s.report()
    timer.join()
    assert s.report().startswith("<!DOCTYPE html>")
    assert s.probe("a.reaction.y") == pytest.approx(1.0)


def test_parts_have_names_of_their_own():
    m = dotyk.examples.punch()
    with pytest.raises(dotyk.InputError, match="a contact and a bar are named `sole`"):
        m.bar("sole", from_=[0, 0], to=[0, 1], bodies=["block"], young=1.0, area=1.0)
    with pytest.raises(dotyk.InputError, match="two bodies are named `punch`"):
        m.body("punch", dotyk.rectangle([0, 0], [1, 1], cells=[1, 1]), young=1.0, poisson=0.0)
    assert m.probe("sole", "sole.pressure", reduce="max").solve().probes["sole"] > 0


@pytest.mark.parametrize("given", [lambda p, t: p[:, 0] + 1j, lambda p, t: ["1.5"] * len(p), lambda p, t: None])
def test_functions_give_numbers(given):
    m = dotyk.examples.punch()
    m.bodies["punch"].load("top", pressure=given)
    with pytest.raises(dotyk.InputError, match="body `punch`, load on `top`, pressure"):
        m.solve()
    m = dotyk.examples.punch()
    m.bodies["punch"].load("top", pressure=lambda p, t: np.full(len(p), np.inf))
    with pytest.raises(dotyk.InputError, match=r"inf at \[1.5"):
        m.solve()


@pytest.mark.parametrize("path", ["", "a\0b", "\ud800"])
def test_paths_that_are_none_are_refused(path):
    for call in (dotyk.run, dotyk.read, dotyk.check, dotyk.examples.punch().solve().write):
        with pytest.raises(dotyk.InputError):
            call(path)


def test_a_report_appears_whole_or_not_at_all(tmp_path):
    s = dotyk.examples.punch().solve()
    s.report(tmp_path / "report.html")
    with pytest.raises(dotyk.InputError, match="cannot write"):
        s.report(tmp_path / "none" / "report.html")
    (tmp_path / "folder").mkdir()
    with pytest.raises(dotyk.InputError, match="cannot write"):
        s.report(tmp_path / "folder")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["folder", "report.html"]


def test_contacts_are_found_between_bodies():
    m = dotyk.Model("plane-strain")
    base = m.body("base", dotyk.rectangle([0, 0], [6, 1], cells=[12, 2]), young=1000, poisson=0.0).fix("bottom", x=0, y=0)
    blocks = [
        m.body(f"b{k}", dotyk.rectangle([2 * k, 1], [2 * k + 1, 2], cells=[3, 2]), young=1000, poisson=0.0) for k in range(3)
    ]
    for block in blocks:
        block.fix("left", x=0).load("top", pressure=1.0)
    m.contact("c", bodies=[*blocks, base], reach=0.25)
    m.probe("first", quantity="c-base-b0.resultant.y")
    m.probe("none", quantity="c-b0-b2.resultant.y")
    check = m.check()
    assert list(check.contacts) == ["c-base-b0", "c-base-b1", "c-base-b2"] and check.notes == []
    s = m.solve()
    assert list(s.contacts) == list(check.contacts)
    for contact in s.contacts.values():
        assert np.allclose(contact.resultant, [0, -1], atol=1e-9)
    assert s.probes["first"] == pytest.approx(-1.0) and np.isnan(s.probes["none"])
    assert s.probe("c-base-b1.resultant.y") == pytest.approx(-1.0) and np.isnan(s.probe("c-b0-b2.resultant.y"))
    assert any('"none"' in warning for warning in s.warnings)
    with pytest.raises(dotyk.InputError, match="nearest"):
        m.contact("d", bodies=[blocks[0], "b1"])
    written = dotyk.Model("plane-strain")
    written.body("base", dotyk.rectangle([0, 0], [6, 1], cells=[12, 2]), young=1000, poisson=0.0).fix("bottom", x=0, y=0)
    written.body("top", dotyk.rectangle([0, 1], [6, 2], cells=[5, 2]), young=1000, poisson=0.0)
    written.contact("all", bodies="all").contact("w", sides=["base.left", "top.left"])
    assert list(written.check().contacts) == ["w"] and "left to contact" in written.check().notes[0]


def test_tools_are_drawn_by_arrays():
    m = dotyk.Model("plane-strain")
    m.body("block", dotyk.rectangle([0, 0], [4, 2], cells=[7, 4], cell="quad9"), young=1000, poisson=0.3).fix("bottom", y=0).fix(
        point=[0, 0], x=0
    )
    outline = np.array([[-1.0, 2.0], [1.3, 2.0], [5.0, 2.0]])
    m.contact("tool", nonmortar="block.top", obstacle={"outline": outline, "force": [0, -40]})
    s = m.solve()
    assert np.allclose(s.contacts["tool"].pressure, 10, rtol=1e-8)


def test_expressions_of_probes():
    m = dotyk.Model("plane-strain", parameters={"depth": 2.0})
    block = m.body("block", dotyk.rectangle([0, 0], [2, 1], cells=[4, 2]), young=1e3, poisson=0.2)
    block.fix("bottom", x=0, y=0).load("top", pressure="t*(1 + x)")
    m.probe("left", "block.displacement.y", at=[0, 1]).probe("right-side", "block.displacement.y", at=[2, 1])
    m.probe("line", "block.stress.yy", along="block.top")
    m.probe("tilt", expression="(left - 'right-side')/depth").probe("twice", expression="2*tilt")
    s = m.solve(steps=[0.5, 1.0])
    for step in s.steps:
        tilt = (step.probes["left"] - step.probes["right-side"]) / 2
        assert step.probes["tilt"] == tilt and step.probes["twice"] == 2 * tilt > 0
        assert step.probe(expression="tilt/depth") == tilt / 2
    assert s.probes["tilt"].quantity == "(left - 'right-side')/depth"
    assert pickle.loads(pickle.dumps(s)).probe(expression="twice*t") == s.probes["twice"]
    study = m.study(vary={"depth": [1.0, 2.0]})
    assert study["tilt"][0] == 2 * study["tilt"][1]
    wrong = [
        ("tilt + nothing", "unknown name `nothing`"),
        ("'right side'", "there is no probe 'right side', the nearest known is 'right-side'"),
        ("2*line", "the probe `line` has values along a line"),
        ("", "the expression is empty"),
    ]
    for expression, words in wrong:
        with pytest.raises(dotyk.InputError, match=words):
            m.probe("wrong", expression=expression)
        with pytest.raises(dotyk.InputError, match=words):
            s.probe(expression=expression)
    with pytest.raises(dotyk.InputError, match="has no `at`"):
        m.probe("wrong", expression="left", at=[0, 1])
    with pytest.raises(dotyk.ArgumentError, match="`expression` is a string"):
        m.probe("wrong", expression=lambda points, t: t)
    assert "wrong" not in m.solve().probes


def test_a_study_tells_all_load_steps():
    m = dotyk.Model("plane-strain", parameters={"q": 1.0, "n": 2})
    mesh = {"rectangle": {"from": [0, 0], "to": [1, 1], "cells": ["n", 2]}}
    block = m.body("block", mesh, young=1e3, poisson=0).fix("bottom", x=0, y=0).load("top", pressure="q*t")
    m.probe("top", f"{block.name}.displacement.y", at=[0.5, 1]).step(0.5).step(1.0)
    vary = {"q": [1.0, 2.0], "n": [2, 2.5]}
    last, study = m.study(vary=vary), m.study(vary=vary, steps="all")
    assert list(last) == ["q", "n", "top", "converged", "reason"] and len(last) == 4
    assert list(study) == ["q", "n", "step", "time", "top", "converged", "reason"] and len(study) == 6
    assert study["step"].tolist() == [1, 2, 1] * 2 and study["step"].dtype.kind == "i"
    assert study["time"][:2].tolist() == [0.5, 1.0] and np.isnan(study["time"][2])
    assert np.allclose(study["top"][:2], [-0.0005, -0.001]) and study["top"][1] == last["top"][0]
    assert study["converged"].tolist() == [True, True, False] * 2 and not study.converged
    assert study.to_pandas().shape == (6, 7) and "6 load steps" in repr(study)
    for wrong in ("first", ["all"], [0.5], None):
        with pytest.raises(dotyk.ArgumentError, match='`steps` of a study is "last" or "all"'):
            m.study(vary=vary, steps=wrong)
    m.probe("time", "block.reaction.y")
    assert len(m.study(vary={"q": [1.0]})) == 1
    with pytest.raises(dotyk.InputError, match="two columns are both named `time`"):
        m.study(vary={"q": [1.0]}, steps="all")

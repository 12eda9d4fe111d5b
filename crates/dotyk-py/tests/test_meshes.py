"""Meshes of arrays, of meshio and of files: their groups, sides and points."""

import pickle

import numpy as np
import pytest

import dotyk

#: A plate of two cells, 2 by 1.
PLATE = [[0, 0], [1, 0], [2, 0], [0, 1], [1, 1], [2, 1]]
QUADS = [[0, 1, 4, 3], [1, 2, 5, 4]]


def meshio_mesh(points, cells, **more):
    return pytest.importorskip("meshio").Mesh(points, cells, **more)


def area(mesh):
    """Of cells with straight edges, by their corners."""
    total = 0.0
    for key, cells in mesh.cells.items():
        kind = key if isinstance(key, str) else key[0]
        x, y = mesh.points[cells[:, : int(kind[-1])]].transpose(2, 0, 1)
        total += 0.5 * (x * np.roll(y, -1, 1) - y * np.roll(x, -1, 1)).sum()
    return total


def test_arrays_have_the_side_boundary():
    mesh = dotyk.Mesh(PLATE, {"quad4": QUADS}, {"floor": [[0, 1], [1, 2]]})
    assert set(mesh.sides) == {"boundary", "floor"} and len(mesh.sides["boundary"]) == 6
    m = dotyk.Model("plane-strain")
    m.body("a", mesh, young=1e6, poisson=0.3).fix("floor", x=0, y=0).load("boundary", pressure=1.0)
    assert m.solve().bodies["a"].max_displacement > 0
    own = dotyk.Mesh(PLATE, {"quad4": QUADS}, {"boundary": [[0, 1]]})
    assert len(own.sides["boundary"]) == 1


def test_generated_meshes_keep_their_sides_when_pickled():
    mesh = dotyk.rectangle([0, 0], [2, 1], cells=[2, 1])
    assert set(pickle.loads(pickle.dumps(mesh)).sides) == set(mesh.sides)
    own = dotyk.Mesh(PLATE, {"quad4": QUADS})
    assert set(pickle.loads(pickle.dumps(own)).sides) == {"boundary"}


@pytest.mark.parametrize("cell", ["tri3", "tri6", "quad8", "quad9"])
def test_prisms_and_bricks_go_to_meshio_and_back(cell, tmp_path):
    pytest.importorskip("meshio")
    solid = dotyk.extrude(dotyk.rectangle([0, 0], [2, 1], cells=[2, 1], cell=cell), height=1, layers=2)
    there = solid.to_meshio()
    back = dotyk.read(there)
    assert {kind: len(cells) for kind, cells in back.cells.items()} == {k: len(c) for k, c in solid.cells.items()}
    assert set(back.sides) == {*solid.sides, "boundary"}
    there.cell_sets.clear()
    there.write(tmp_path / "solid.vtu")
    assert dotyk.read(tmp_path / "solid.vtu").cells.keys() == solid.cells.keys()


def test_sets_of_abaqus_are_groups_sides_and_points(tmp_path):
    (tmp_path / "layers.inp").write_text(
        "*NODE\n1, 0., 0.\n2, 1., 0.\n3, 2., 0.\n4, 0., 1.\n5, 1., 1.\n6, 2., 1.\n"
        "*ELEMENT, TYPE=CPS4, ELSET=Eall\n1, 1, 2, 5, 4\n2, 2, 3, 6, 5\n"
        "*ELSET, ELSET=sand\n1\n*ELSET, ELSET=clay\n2\n"
        "*NSET, NSET=floor\n1, 2, 3\n*NSET, NSET=gauge\n5\n*NSET, NSET=two tips\n1, 6\n*NSET, NSET=Nall\n1, 2, 3, 4, 5, 6\n"
    )
    pytest.importorskip("meshio")
    mesh = dotyk.read(tmp_path / "layers.inp")
    assert {group for _, group in mesh.cells} == {"sand", "clay"}
    assert set(mesh.sides) == {"floor", "boundary"} and len(mesh.sides["floor"]) == 2
    assert mesh.named == {"gauge": [[1.0, 1.0]], "two_tips": [[0.0, 0.0], [2.0, 1.0]]}
    assert any("`two tips` is called `two_tips`" in warning for warning in mesh.warnings)
    sand = dotyk.read(tmp_path / "layers.inp", group="sand")
    assert area(sand) == pytest.approx(1.0) and len(sand.points) == 4
    # the nodes of the floor that the body has
    assert sand.sides["floor"].tolist() == [[0, 1]]
    with pytest.raises(dotyk.InputError, match="no group of cells `rock`; it has sand, clay, Eall"):
        dotyk.read(tmp_path / "layers.inp", group="rock")


def test_families_of_med_are_groups_sides_and_points(tmp_path):
    pytest.importorskip("h5py")
    mesh = meshio_mesh(
        [[*p, 0.0] for p in PLATE],
        [("quad", QUADS), ("line", [[0, 1], [1, 2], [1, 4]])],
        cell_data={"cell_tags": [np.array([-6, -7]), np.array([-8, -8, -9])]},
        point_data={"point_tags": np.array([0, 0, 2, 3, 3, 3])},
    )
    mesh.cell_tags = {-6: ["sand", "ground"], -7: ["ground"], -8: ["floor"], -9: ["inside"]}
    mesh.point_tags = {2: ["gauge"], 3: ["top"]}
    mesh.write(tmp_path / "plate.med")
    read = dotyk.read(tmp_path / "plate.med")
    assert sorted(key[1] for key in read.cells) == ["ground", "sand"]
    assert set(read.sides) == {"boundary", "floor", "top"} and len(read.sides["top"]) == 2
    assert read.named == {"gauge": [[2.0, 0.0]]}
    assert any("1 facets of the group `inside` lie inside the body" in warning for warning in read.warnings)
    assert area(dotyk.read(tmp_path / "plate.med", group="ground")) == pytest.approx(2.0)


def test_a_set_of_nodes_beside_a_facet_is_told():
    mesh = dotyk.read(meshio_mesh(PLATE, [("quad", QUADS)], point_sets={"corner": [0, 1, 5]}))
    assert mesh.sides["corner"].tolist() == [[0, 1]]
    assert any("1 of the 3 nodes of the set `corner`" in warning for warning in mesh.warnings)
    # a middle node that the set does not have is no reason against a side of second order
    plate = dotyk.rectangle([0, 0], [2, 1], cells=[2, 1], cell="quad8")
    there = plate.to_meshio()
    there.cell_sets.clear()
    corners = [k for k, (x, y) in enumerate(plate.points) if y == 0 and x in (0, 1, 2)]
    there.point_sets["floor"] = np.array(corners)
    assert dotyk.read(there).sides["floor"].shape == (2, 3)


def test_numbers_of_groups_are_their_names(tmp_path):
    (tmp_path / "plate.mesh").write_text(
        "MeshVersionFormatted 2\nDimension 2\nVertices\n6\n0 0 0\n1 0 0\n2 0 0\n0 1 0\n1 1 0\n2 1 0\n"
        "Edges\n2\n1 2 5\n2 3 5\nQuadrilaterals\n2\n1 2 5 4 1\n2 3 6 5 2\nEnd\n"
    )
    pytest.importorskip("meshio")
    mesh = dotyk.read(tmp_path / "plate.mesh")
    assert {group for _, group in mesh.cells} == {"1", "2"} and set(mesh.sides) == {"5", "boundary"}


def test_points_of_groups_of_gmsh_come_with_meshio():
    mesh = dotyk.read(
        meshio_mesh(
            PLATE,
            [("quad", QUADS), ("vertex", [[4]])],
            cell_data={"gmsh:physical": [np.array([1, 1]), np.array([3])]},
            field_data={"rock": np.array([1, 2]), "gauge": np.array([3, 0])},
        )
    )
    assert mesh.named == {"gauge": [[1.0, 1.0]]}


def test_the_dimension_of_a_file_is_told(tmp_path):
    plate = meshio_mesh([[*p, 1.0] for p in PLATE], [("quad", QUADS)])
    assert dotyk.read(plate).dimension == 2
    with pytest.raises(dotyk.InputError, match="no cells of space"):
        dotyk.read(plate, space=True)
    shell = meshio_mesh([[*p, float(p[0])] for p in PLATE], [("quad", QUADS)])
    with pytest.raises(dotyk.InputError, match="z runs from 0 to 2"):
        dotyk.read(shell)
    box = dotyk.box([0, 0, 0], [1, 1, 1], cells=[2, 2, 2]).to_meshio()
    with pytest.raises(dotyk.InputError, match="z runs from 0 to 1"):
        dotyk.read(box, space=False)


def test_ucd_files_are_told_from_decks(tmp_path):
    pytest.importorskip("meshio")
    (tmp_path / "plate.inp").write_text(
        "# a comment\n6 2 0 0 0\n1 0 0 0\n2 1 0 0\n3 2 0 0\n4 0 1 0\n5 1 1 0\n6 2 1 0\n"
        "1 7 quad 1 2 5 4\n2 8 quad 2 3 6 5\n"
    )
    mesh = dotyk.read(tmp_path / "plate.inp")
    assert set(mesh.cells) == {("quad4", "7"), ("quad4", "8")} and area(mesh) == pytest.approx(2.0)


def test_files_that_no_program_reads_are_refused_with_their_name(tmp_path):
    pytest.importorskip("meshio")
    for name, text in [("a.med", "nothing"), ("b.inp", "** nothing\n"), ("c.what", "nothing"), ("d.vtk", "")]:
        (tmp_path / name).write_text(text)
        with pytest.raises(dotyk.InputError, match=name):
            dotyk.read(tmp_path / name)
    with pytest.raises(dotyk.InputError, match="no such file"):
        dotyk.read(tmp_path / "none.med")


def test_pyramids_and_what_looks_like_one_are_refused(tmp_path):
    points = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 1.0]]
    with pytest.raises(dotyk.InputError, match="1 `pyramid`.*tied"):
        dotyk.read(meshio_mesh(points, [("pyramid", [[0, 1, 2, 3, 4]])]))
    with pytest.raises(dotyk.InputError, match="names node 4 twice"):
        dotyk.Mesh(points, {"hex8": [[0, 1, 2, 3, 4, 4, 4, 4]]})
    with pytest.raises(dotyk.InputError, match="unknown kind of cells `pyramid5`"):
        dotyk.Mesh(points, {"pyramid5": [[0, 1, 2, 3, 4]]})


def test_files_of_exodus_have_their_own_order_of_nodes(tmp_path):
    pytest.importorskip("netCDF4")
    box = dotyk.box([0, 0, 0], [2, 1, 1], cells=[2, 1, 1], cell="hex20")
    # the edges from bottom to top come before those of the top
    cells = box.cells["hex20"][:, [*range(12), *range(16, 20), *range(12, 16)]]
    floor = np.flatnonzero(box.points[:, 2] == 0)
    meshio_mesh(box.points, [("hexahedron20", cells)], point_sets={"floor": floor}).write(tmp_path / "box.e")
    mesh = dotyk.read(tmp_path / "box.e")
    assert np.array_equal(mesh.cells["hex20"], box.cells["hex20"])
    assert len(mesh.sides["floor"]) == 2 and len(mesh.sides["boundary"]) == 10


def test_sets_without_a_name_are_left_out_with_a_word():
    mesh = dotyk.read(meshio_mesh(PLATE, [("quad", QUADS)], cell_sets={" ": [[0]], "sand": [[1]]}))
    assert {key if isinstance(key, str) else key[1] for key in mesh.cells} == {"quad4", "sand"}
    assert mesh.warnings == ["a set without a name is left out"]

"""Writes square.toml and hexagonal.toml: python3 generate.py"""

from math import cos, pi, sin, sqrt
from pathlib import Path

HERE = Path(__file__).parent
RADIUS = 1.0
AROUND = 36
HALF_ANGLE = 2 * pi / AROUND
DISC = "{ young = 20000.0, poisson = 0.3 }"
PLATE = "{ young = 1e6, poisson = 0.3 }"
PRESSURE = 20.0


def head(title):
    return f'title    = "{title}"\nanalysis = "plane-strain"\nunits    = {{ length = "mm", force = "N" }}\n'


def patch(name, center, angle):
    ends = [angle - HALF_ANGLE, angle, angle + HALF_ANGLE]
    slack = 1e-6
    corners = [[c + RADIUS * f(a) for a in ends] for c, f in zip(center, (cos, sin))]
    low = [min(c) - slack for c in corners]
    high = [max(c) + slack for c in corners]
    box = [", ".join(f"{v:.7f}" for v in p) for p in (low, high)]
    return f'{name} = {{ of = "outer", min = [{box[0]}], max = [{box[1]}] }}'


def disc(name, center, patches):
    x, y = (f"{c:.10g}" for c in center)
    sides = ", ".join(patch(n, center, a) for n, a in patches)
    ring = f"inner = 0.15, outer = 1.0, cells = [{AROUND}, 6], ratio = 0.9"
    return (
        f'\n[[body]]\nname     = "{name}"\n'
        f"mesh     = {{ ring = {{ center = [{x}, {y}], {ring} }}, sides = {{ {sides} }} }}\n"
        f"material = {DISC}\n"
        f"surface  = {{ outer = {{ circle = {{ center = [{x}, {y}], radius = 1.0 }} }} }}\n"
    )


def pair(point):
    return ", ".join(f"{v:.10g}" for v in point)


def plate(name, low, high, inner, extra):
    """Cells of 0.25 along the plate; `inner` faces the discs and has a patch of two cells opposite each of them."""
    lying = inner in ("top", "bottom")
    along = round((high[0] - low[0] if lying else high[1] - low[1]) / 0.25)
    cells = [along, 3] if lying else [3, along]
    level = {"top": high[1], "bottom": low[1], "right": high[0], "left": low[0]}[inner]
    patches = []
    for k in range(10):
        ends = [(v, level) if lying else (level, v) for v in (2 * k + 0.75, 2 * k + 1.25)]
        patches.append(f'at_{k} = {{ of = "{inner}", min = [{pair(ends[0])}], max = [{pair(ends[1])}] }}')
    sides = ", ".join(patches)
    return (
        f'\n[[body]]\nname     = "{name}"\n'
        f"mesh     = {{ rectangle = {{ from = [{pair(low)}], to = [{pair(high)}], cells = {cells} }}, sides = {{ {sides} }} }}\n"
        f"material = {PLATE}\n{extra}\n"
    )


def contact(name, nonmortar, mortar):
    return f'\n[[contact]]\nname      = "{name}"\nnonmortar = "{nonmortar}"\nmortar    = "{mortar}"\n'


def wall(name, side, point, normal):
    shape = f"{{ plane = {{ point = [{point}], normal = [{normal}] }} }}"
    return f'\n[[contact]]\nname      = "{name}"\nnonmortar = "{side}"\nobstacle  = {shape}\n'


def probe(name, quantity):
    return f'\n[[probe]]\nname     = "{name}"\nquantity = "{quantity}"\n'


def square(n=10):
    quarter = [("east", 0.0), ("north", pi / 2), ("west", pi), ("south", -pi / 2)]
    size = 2 * RADIUS * n
    text = head("100 discs in a box, square packing, pressed from above and from the right")
    for i in range(n):
        for j in range(n):
            text += disc(f"disc_{i}_{j}", (2 * i + 1, 2 * j + 1), quarter)
    rollers_x = '{ side = "left", x = 0.0 }, { side = "right", x = 0.0 }'
    rollers_y = '{ side = "bottom", y = 0.0 }, { side = "top", y = 0.0 }'
    fix = "fix      = ["
    # the two would meet at the corner: both end a cell before it, and with the same force
    low, high = 0.25, size - 0.25
    load = f'pressure = "{PRESSURE} * {size} / {high - low}" }}]'
    text += plate("lid", (low, size), (high, size + 2), "bottom", f'{fix}{rollers_x}]\nload     = [{{ side = "top", {load}')
    text += plate("press", (size, low), (size + 2, high), "left", f'{fix}{rollers_y}]\nload     = [{{ side = "right", {load}')
    for k in range(n):
        text += wall(f"floor_{k}", f"disc_{k}_0.south", "0.0, 0.0", "0.0, 1.0")
        text += wall(f"left_{k}", f"disc_0_{k}.west", "0.0, 0.0", "1.0, 0.0")
        text += contact(f"lid_{k}", f"lid.at_{k}", f"disc_{k}_{n-1}.north")
        text += contact(f"press_{k}", f"press.at_{k}", f"disc_{n-1}_{k}.east")
    for i in range(n):
        for j in range(n):
            if i + 1 < n:
                text += contact(f"row_{i}_{j}", f"disc_{i}_{j}.east", f"disc_{i+1}_{j}.west")
            if j + 1 < n:
                text += contact(f"column_{i}_{j}", f"disc_{i}_{j}.north", f"disc_{i}_{j+1}.south")
    for k in range(n):
        text += probe(f"floor under column {k}", f"floor_{k}.resultant.y")
        text += probe(f"lid on column {k}", f"lid_{k}.resultant.y")
        text += probe(f"left wall at row {k}", f"left_{k}.resultant.x")
        text += probe(f"press on row {k}", f"press_{k}.resultant.x")
    for i, j in ((0, 0), (4, 4), (8, 3), (3, 8)):
        text += probe(f"in row, {i} {j}", f"row_{i}_{j}.resultant.x")
        text += probe(f"in column, {j} {i}", f"column_{j}_{i}.resultant.y")
    return text


def hexagonal(rows=5, n=10):
    step = sqrt(3.0)
    sixth = [("east", 0.0), ("northeast", pi / 3), ("northwest", 2 * pi / 3), ("west", pi)]
    sixth += [("southwest", -2 * pi / 3), ("southeast", -pi / 3), ("north", pi / 2), ("south", -pi / 2)]
    needed = {}
    text = head("48 discs in a box, hexagonal packing, pressed by a lid")
    joints = ""
    size = 2 * RADIUS * n
    top = 2 * RADIUS + (rows - 1) * step
    count = lambda j: n - j % 2

    def side(i, j, where):
        needed.setdefault((i, j), []).append(where)
        return f"disc_{i}_{j}.{where}"

    for j in range(rows):
        for i in range(count(j)):
            if i + 1 < count(j):
                joints += contact(f"row_{i}_{j}", side(i, j, "east"), side(i + 1, j, "west"))
            if j + 1 < rows:
                left, right = (i - 1, i) if j % 2 == 0 else (i, i + 1)
                if left >= 0:
                    joints += contact(f"left_up_{i}_{j}", side(i, j, "northwest"), side(left, j + 1, "southeast"))
                if right < count(j + 1):
                    joints += contact(f"right_up_{i}_{j}", side(i, j, "northeast"), side(right, j + 1, "southwest"))
        if j % 2 == 0:
            joints += wall(f"left_{j}", side(0, j, "west"), "0.0, 0.0", "1.0, 0.0")
            joints += wall(f"right_{j}", side(n - 1, j, "east"), f"{size}, 0.0", "-1.0, 0.0")
    for i in range(n):
        joints += contact(f"floor_{i}", f"floor.at_{i}", side(i, 0, "south"))
        joints += contact(f"lid_{i}", f"lid.at_{i}", side(i, rows - 1, "north"))
    angles = dict(sixth)
    for (i, j), sides in sorted(needed.items()):
        center = (2 * i + 1 + j % 2, 1 + j * step)
        text += disc(f"disc_{i}_{j}", center, [(s, angles[s]) for s in sides])
    rollers = '{ side = "left", x = 0.0 }, { side = "right", x = 0.0 }'
    text += plate("floor", (0, -2), (size, 0), "top", f'fix      = [{{ side = "bottom", y = 0.0 }}, {rollers}]')
    load = f'load     = [{{ side = "top", pressure = {PRESSURE} }}]'
    text += plate("lid", (0, top), (size, top + 2), "bottom", f"fix      = [{rollers}]\n{load}")
    text += joints
    text += probe("floor", "floor.bottom.reaction.y")
    for k in range(n):
        text += probe(f"floor {k}", f"floor_{k}.resultant.y")
    for j in range(0, rows, 2):
        text += probe(f"left wall, row {j}", f"left_{j}.resultant.x")
        text += probe(f"right wall, row {j}", f"right_{j}.resultant.x")
    return text


if __name__ == "__main__":
    (HERE / "square.toml").write_text(square())
    (HERE / "hexagonal.toml").write_text(hexagonal())

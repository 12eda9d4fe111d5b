"""The page of the book and its pictures, from what a run has recorded: no figure is typed by hand."""

from __future__ import annotations

import json
import math
from pathlib import Path

HERE = Path(__file__).resolve().parent
RECORD = HERE / "record.json"
BOOK = HERE.parent.parent / "docs" / "reference"
PAGE = BOOK / "peers.md"
PICTURES = BOOK / "peers"
KEPT = ("state", "reason", "values", "differences", "median", "threads")
COLOURS = {
    "dotyk": "#b3261e",
    "dotyk_threads": "#e8817b",
    "getfem": "#1f5fa8",
    "calculix": "#2d7d46",
    "calculix_iterative": "#7cb342",
    "ngsolve": "#8e44ad",
    "kratos": "#c77700",
}


def record(results: dict) -> None:
    """The medians of a run, without its single runs."""
    for entry in results["problems"]:
        entry["results"] = {
            name: {key: result[key] for key in KEPT if key in result} for name, result in entry["results"].items()
        }
    RECORD.write_text(json.dumps(rounded(results), indent=1) + "\n")


def rounded(value):
    """Five digits of every number."""
    if isinstance(value, float):
        return float(f"{value:.5g}") if math.isfinite(value) else None
    if isinstance(value, dict):
        return {key: rounded(part) for key, part in value.items()}
    return [rounded(part) for part in value] if isinstance(value, list) else value


# ---------------------------------------------------------------------------------------------------------------------
# Pictures


def ticks(low: float, high: float) -> list[float]:
    """Powers of ten inside, and twice and five times them where there are few."""
    powers = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    for factors in ((1,), (1, 2, 5)):
        found = [factor * 10.0**power for power in powers for factor in factors if low <= factor * 10.0**power <= high]
        if len(found) >= 3:
            break
    return found


WIDE, HIGH, LEFT, RIGHT, TOP, BOTTOM = 300, 300, 46, 10, 34, 46


def panel(label: str, lines: dict[str, list[tuple[float, float]]], shift: float) -> list[str]:
    """Curves over the number of unknowns, both axes logarithmic."""
    points = [point for line in lines.values() for point in line]
    low = [min(point[axis] for point in points) / 1.3 for axis in (0, 1)]
    high = [max(point[axis] for point in points) * 1.3 for axis in (0, 1)]
    first, last, ground = shift + LEFT, shift + WIDE - RIGHT, HIGH - BOTTOM

    def place(point: tuple[float, float]) -> tuple[float, float]:
        x, y = (math.log(point[axis] / low[axis]) / math.log(high[axis] / low[axis]) for axis in (0, 1))
        return first + x * (last - first), ground - y * (ground - TOP)

    text = [f'<text x="{first}" y="{TOP - 12}" font-size="13">{label}</text>']
    for axis in (0, 1):
        for tick in ticks(low[axis], high[axis]):
            x, y = place((tick, low[1]) if axis == 0 else (low[0], tick))
            end = (x, TOP) if axis == 0 else (last, y)
            text.append(f'<line x1="{x:.1f}" y1="{y:.1f}" x2="{end[0]:.1f}" y2="{end[1]:.1f}" stroke="#ddd"/>')
            word = f"{tick:g}" if tick < 1e3 else f"{tick / 1e3:g}k" if tick < 1e6 else f"{tick / 1e6:g}M"
            at = (x, y + 16, "middle") if axis == 0 else (x - 5, y + 4, "end")
            text.append(f'<text x="{at[0]:.1f}" y="{at[1]:.1f}" text-anchor="{at[2]}">{word}</text>')
    text.append(f'<text x="{(first + last) / 2}" y="{HIGH - 10}" text-anchor="middle">displacement unknowns</text>')
    for name, line in lines.items():
        spots = [place(point) for point in sorted(line)]
        way = " ".join(f"{x:.1f},{y:.1f}" for x, y in spots)
        text.append(f'<polyline points="{way}" fill="none" {stroke(name)}/>')
        text += [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="2.5" fill="{COLOURS[name]}"/>' for x, y in spots]
    return text


def stroke(name: str) -> str:
    dash = ' stroke-dasharray="5 3"' if name in ("dotyk_threads", "calculix_iterative") else ""
    return f'stroke="{COLOURS[name]}" stroke-width="2"{dash}'


def picture(path: Path, panels: dict[str, dict[str, list[tuple[float, float]]]], names: dict[str, str]) -> None:
    """Panels side by side, and the names of the curves."""
    used = list(next(iter(panels.values())))
    width = len(panels) * WIDE + 150
    text = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {HIGH}" font-family="sans-serif" font-size="11">',
        f'<rect width="{width}" height="{HIGH}" fill="white"/>',
    ]
    for number, (label, lines) in enumerate(panels.items()):
        text += panel(label, lines, number * WIDE)
    for number, name in enumerate(used):
        x, y = len(panels) * WIDE + 8, TOP + 12 + 20 * number
        text.append(f'<line x1="{x}" y1="{y}" x2="{x + 24}" y2="{y}" {stroke(name)}/>')
        text.append(f'<text x="{x + 30}" y="{y + 4}">{names[name]}</text>')
    path.write_text("\n".join([*text, "</svg>"]) + "\n")


# ---------------------------------------------------------------------------------------------------------------------
# The page


def table(head: list[str], rows: list[list[str]]) -> list[str]:
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return lines + ["| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |" for row in rows] + [""]


def seconds(value: float) -> str:
    return f"{value:.0f}" if value >= 100 else f"{value:.3g}"


def percent(value: float | None, digits: int = 2) -> str:
    return "not a number" if value is None else f"{100 * value:+.{digits}f} %"


def cell(result: dict | None, kind: str) -> str:
    """What a program took, or why there is nothing."""
    if result is None:
        return ""
    if "median" in result:
        median = result["median"]
        if kind == "memory":
            return f"{median['memory'] / 2**20:.0f}"
        return f"{seconds(median['wall'])} ({seconds(median['solve'])})"
    return {"excluded": "-", "disagrees": "disagrees", "failed": "fails"}.get(result["state"], "")


def slower(problems: list[dict], key: str, name: str) -> str:
    """By how much the fastest peer is slower than dotyk at the largest size that both have."""
    for entry in reversed(problems):
        results = entry["results"]
        own = results.get(name, {}).get("median")
        peers = [
            result["median"][key]
            for label, result in results.items()
            if "median" in result and not label.startswith("dotyk")
        ]
        if own and peers:
            return f"{min(peers) / own[key]:.2g} at {entry['dofs']} unknowns"
    return "nothing to compare"


def write() -> None:
    data = json.loads(RECORD.read_text())
    programs, machine = data["programs"], data["machine"]
    names = {name: told["name"] for name, told in programs.items()}
    names["dotyk_threads"] = f"dotyk, {machine['cores']} threads"
    groups: dict[str, list[dict]] = {}
    for entry in data["problems"]:
        groups.setdefault(entry["problem"], []).append(entry)
    runs = "one run each" if data["repeat"] == 1 else f"medians of {data['repeat']} runs in turns"
    memory = machine["memory"] / 2**30
    limits = data["limits"]
    lines = [
        "# Beside other programs",
        "",
        "Made by `bench/peers/run --page` from `bench/peers/record.json`; `bench/peers/run --record` makes both anew.",
        "",
        "Every program gets the same nodes and cells, the same supports, loads and contact pair, and the settings that its own "
        "documentation advises. Each solves every problem once. Its displacements are measured by one ruler: forces inside "
        "the body give the contact forces at its nodes, whatever a program says about pressures. Only programs whose answers "
        "agree are timed.",
        "",
        f"Machine: {machine['cpu']}, {machine['cores']} processors, {memory:.0f} GiB, {machine['system']}, Linux "
        f"{machine['kernel']}; {data['date']}; {runs}; one thread, but for the column that says otherwise.",
        "",
        "## The programs",
        "",
        *table(
            ["Program", "Version", "Settings", "What counts as the solve"],
            [[told["name"], told["version"], told["settings"], told["solve"]] for told in programs.values()],
        ),
        "What counts as the whole is the process from its start to its end: for the Python modules with their imports and the "
        "mesh made in memory, for dotyk and CalculiX with reading their files and writing results, dotyk's report among them. "
        "Input files are written before the clock starts. Memory is the largest resident size of the process.",
        "",
        "## When answers agree",
        "",
        "Each is compared with dotyk: the integral of the pressure (force), that of shear, the largest pressure at a node, and "
        "the root mean square difference of all pressures. Force and shear are parts of the force.",
        "",
        *table(
            ["Limit of", "force", "shear", "largest pressure", "all pressures"],
            [
                [who, *(f"{100 * limits[kind][key]:g} %" for key in ("force", "shear", "largest", "pressures"))]
                for who, kind in (("multipliers", "variational"), ("penalties (CalculiX, NGSolve)", "penalty"))
            ],
        ),
    ]
    for problem, other in limits["coarse"].items():
        if problem in groups:
            title = groups[problem][0]["title"]
            lines += [
                f"For *{title}* the limit of force is {100 * other['force']:g} %: the meshes hold no more digits.",
                "",
            ]
    for problem in limits["shown"]:
        if problem in groups:
            title = groups[problem][0]["title"]
            lines += [f"For *{title}* pressures are shown, not judged: at its edges they grow without bound.", ""]
    lines += [
        "What a program tells as its force (reactions) must be that of its displacements, and no force may be left at free "
        "nodes. dotyk counts as confirmed where more than half of the peers that answer agree with it; elsewhere nothing is timed. "
        "Where no peer answers any more, dotyk is timed alone.",
        "",
        "## Times",
        "",
        "Whole program in seconds, in brackets the solve.",
        "",
    ]
    order = [name for name in COLOURS if name in names]
    for problem, entries in groups.items():
        used = [name for name in order if any(name in entry["results"] for entry in entries)]
        lines += [f"### {entries[0]['title']}", ""]
        for kind, words in (("time", "s"), ("memory", "MiB")):
            rows = [
                [f"{entry['dofs']}", *(cell(entry["results"].get(name), kind) for name in used)] for entry in entries
            ]
            lines += table([f"Unknowns ({words})", *(names[name] for name in used)], rows)
        lines += [
            f"Time of the fastest peer over that of dotyk: whole {slower(entries, 'wall', 'dotyk')}, solve {slower(entries, 'solve', 'dotyk')}.",
            "",
        ]
        panels = {}
        for kind, label, unit in (
            ("wall", "whole program, s", 1),
            ("solve", "solve, s", 1),
            ("memory", "memory, MiB", 2**20),
        ):
            medians = {
                name: [(entry["dofs"], entry["results"].get(name, {}).get("median")) for entry in entries]
                for name in used
            }
            curves = {
                name: [(dofs, found[kind] / unit) for dofs, found in curve if found] for name, curve in medians.items()
            }
            panels[label] = {name: curve for name, curve in curves.items() if curve}
        if panels["solve, s"]:
            PICTURES.mkdir(exist_ok=True)
            picture(PICTURES / f"{problem}.svg", panels, names)
            lines += [f"![{entries[0]['title']}: time and memory]({PICTURES.name}/{problem}.svg)", ""]
    lines += ["## Answers", "", "Differences from dotyk.", ""]
    for problem, entries in groups.items():
        lines += [f"### {entries[0]['title']}: answers", ""]
        rows = []
        for entry in entries:
            for name in order:
                result = entry["results"].get(name, {})
                if "values" in result:
                    values, apart = result["values"], result["differences"]
                    row = [str(entry["dofs"]), names[name], f"{values['force']:.6g}", percent(apart["force"], 3)]
                    row += [f"{values['shear']:.5g}", percent(apart["shear"])] if problem.endswith("friction") else []
                    row += [
                        f"{values['largest']:.5g}",
                        percent(apart["largest"]),
                        percent(apart["pressures"]).lstrip("+"),
                    ]
                    rows.append([*row, result["state"]])
        shear = ["Shear", ""] if problem.endswith("friction") else []
        lines += table(["Unknowns", "Program", "Force", "", *shear, "Largest pressure", "", "All pressures", ""], rows)
    left_out: dict[tuple[str, str, str, str], list[str]] = {}
    for entry in data["problems"]:
        for name, result in entry["results"].items():
            if result["state"] != "agrees":
                key = (names[name], entry["title"], result["state"], result["reason"])
                left_out.setdefault(key, []).append(str(entry["dofs"]))
    for entry in data["problems"]:
        if entry.get("doubt"):
            left_out[("dotyk", entry["title"], "not confirmed", entry.get("doubt"))] = [str(entry["dofs"])]
    if left_out:
        rows = [[who, what, ", ".join(sizes), state, reason] for (who, what, state, reason), sizes in left_out.items()]
        lines += ["## Not timed", "", *table(["Program", "Problem", "Unknowns", "", "Reason"], rows)]
    PAGE.write_text("\n".join(lines).rstrip("\n") + "\n")
    print(f"wrote {PAGE}")

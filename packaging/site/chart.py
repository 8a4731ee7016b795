"""The chart of the first screen: time and error of clsdf and its peers, by the table of the README."""

import math
import re

WIDTH, HEIGHT = 720, 300
LEFT, RIGHT, TOP, BOTTOM = 70, 40, 30, 46


def rows_of(readme):
    rows = {}
    for line in readme.partition("## How fast")[2].partition("\n\nThe best tree")[0].split("\n"):
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if line.startswith("|") and len(cells) == 5:
            rows[cells[0]] = cells[1:]
    return rows


def points_of(readme):
    """Names, milliseconds and errors in voxels."""
    rows = rows_of(readme)
    names = rows["ms"]
    bunny = next(cells for name, cells in rows.items() if name.startswith("Stanford bunny"))
    errors = rows["largest error, voxel"]
    points = [(name, float(time.replace(",", "")), float(error)) for name, time, error in zip(names, bunny, errors)]
    points[0] = ("clsdf, two cores", *points[0][1:])
    name, cells = next((name, cells) for name, cells in rows.items() if name.startswith("NVIDIA"))
    card = re.match(r"(NVIDIA \w+)", name).group(1)
    points.append((f"clsdf, {card}", float(cells[0]), float(re.search(r"error (\S+)", name).group(1))))
    return points


def power(exponent):
    if exponent == 0:
        return "1"
    return f'10<tspan dy="-5" font-size="9">{"−" if exponent < 0 else ""}{abs(exponent)}</tspan>'


def chart_of(readme):
    points = points_of(readme)

    def x_of(milliseconds):
        return LEFT + (WIDTH - LEFT - RIGHT) * math.log10(milliseconds) / 4

    def y_of(error):
        return TOP + (HEIGHT - TOP - BOTTOM) * (0.5 - math.log10(error)) / 7

    told = "; ".join(f"{name}: {time:g} ms, error {error:g} voxel" for name, time, error in points)
    parts = [f'<svg class="peers-chart" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="{told}">']
    for exponent in range(-6, 1, 2):
        y = y_of(10.0**exponent)
        parts.append(f'<line class="axis" x1="{LEFT}" x2="{WIDTH - RIGHT}" y1="{y:.0f}" y2="{y:.0f}"/>'
                     f'<text class="number" x="{LEFT - 8}" y="{y + 4:.0f}" text-anchor="end">{power(exponent)}</text>')
    for exponent, label in enumerate(("1 ms", "10 ms", "100 ms", "1 s", "10 s")):
        x = x_of(10.0**exponent)
        parts.append(f'<line class="axis" x1="{x:.0f}" x2="{x:.0f}" y1="{TOP}" y2="{HEIGHT - BOTTOM}"/>'
                     f'<text class="number" x="{x:.0f}" y="{HEIGHT - BOTTOM + 18}" text-anchor="middle">{label}</text>')
    parts.append(f'<text x="{(LEFT + WIDTH - RIGHT) / 2:.0f}" y="{HEIGHT - 8}" text-anchor="middle">time of the whole call</text>'
                 f'<text x="{LEFT - 60}" y="{TOP - 12}">largest error, voxel</text>')
    for name, time, error in points:
        own = name.startswith("clsdf")
        x, y = x_of(time), y_of(error)
        at_end = x < WIDTH - 130
        parts.append(f'<circle class="{"own" if own else "peer"}" cx="{x:.1f}" cy="{y:.1f}" r="{7 if own else 6}"/>'
                     f'<text class="{"own-name" if own else "peer-name"}" x="{x + (12 if at_end else -12):.1f}" y="{y - 8:.1f}" '
                     f'text-anchor="{"start" if at_end else "end"}">{name}</text>')
    parts.append("</svg>")
    return "\n".join(parts)

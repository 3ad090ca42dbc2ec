"""Lines over time as an SVG plot, without any library."""

from pathlib import Path
from xml.sax.saxutils import escape

WIDTH, PANEL, LEFT, RIGHT, TOP, GAP = 760, 96, 110, 20, 24, 44
COLORS = ("#1f6fb2", "#b24a1f", "#2f8f4e", "#7a4fb0")


def draw(path: Path, title: str, panels: list):
    """One panel above the other. A panel is (name, unit, [(label, [(minutes, value), ...]), ...]); its axis begins at
    0.
    """
    height = TOP + len(panels) * (PANEL + GAP) + 10
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{height}" viewBox="0 0 {WIDTH} {height}" '
        'font-family="sans-serif" font-size="11">',
        f'<rect width="{WIDTH}" height="{height}" fill="white"/>',
        f'<text x="{LEFT}" y="16" font-size="13" font-weight="bold">{escape(title)}</text>',
    ]
    for k, (name, unit, series) in enumerate(panels):
        lines += panel(TOP + k * (PANEL + GAP) + 14, name, unit, series)
    path.write_text("\n".join([*lines, "</svg>"]) + "\n", encoding="utf-8")


def panel(top: float, name: str, unit: str, series: list) -> list:
    points = [point for _, line in series for point in line]
    last = max((x for x, _ in points), default=1.0) or 1.0
    highest = max((y for _, y in points), default=1.0) * 1.1 or 1.0
    right, bottom = WIDTH - RIGHT, top + PANEL

    def place(x, y):
        return f"{LEFT + (right - LEFT) * x / last:.1f},{bottom - PANEL * y / highest:.1f}"

    lines = [
        f'<rect x="{LEFT}" y="{top}" width="{right - LEFT}" height="{PANEL}" fill="none" stroke="#bbb"/>',
        f'<text x="{LEFT}" y="{top - 4}">{escape(name)}, {escape(unit)}</text>',
    ]
    for share in (0, 0.5, 1):
        y = bottom - PANEL * share
        lines.append(f'<text x="{LEFT - 6}" y="{y + 4:.1f}" text-anchor="end">{shown(highest * share)}</text>')
    for share in (0, 0.5, 1):
        x = LEFT + (right - LEFT) * share
        lines.append(f'<text x="{x:.1f}" y="{bottom + 13}" text-anchor="middle">{last * share:.1f} min</text>')
    for k, (label, line) in enumerate(series):
        color = COLORS[k % len(COLORS)]
        path = " ".join(place(x, y) for x, y in line)
        lines.append(f'<polyline fill="none" stroke="{color}" stroke-width="1.2" points="{path}"/>')
        lines.append(
            f'<text x="{right - 4 - 120 * k}" y="{top - 4}" text-anchor="end" fill="{color}">{escape(label)}</text>'
        )
    return lines


def shown(value: float) -> str:
    return f"{value:,.0f}" if value >= 10 else f"{value:.1f}"

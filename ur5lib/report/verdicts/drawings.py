"""Small pictures of verdicts as SVG, in the colour of the surrounding text."""

import math
from collections.abc import Mapping
from xml.sax.saxutils import quoteattr

WIDTH, HEIGHT = 160.0, 48.0
GAP = 0.25  # of the step from bar to bar
LEAST = 1.5  # height that is still seen
PALE = "fill-opacity='.15'"


def bars(shares: Mapping[str, float]) -> str:
    """Draw shares (0 to 1) by name as bars, each of which fills its frame from below."""
    step = WIDTH / max(len(shares), 1)
    parts = [
        _rectangle(i * step, 0.0, step * (1 - GAP), HEIGHT, PALE)
        + _rectangle(i * step, HEIGHT - height, step * (1 - GAP), height)
        for i, height in enumerate(
            max(HEIGHT * min(x, 1.0), LEAST * (x > 0)) for x in shares.values()
        )
    ]
    label = ", ".join(f"{name}: {100 * share:.0f} %" for name, share in shares.items())
    return _svg("".join(parts), label)


def error_bar(value: float, low: float, high: float, zero: float) -> str:
    """Draw a value as a dot with its interval, if known, beside the error of zero, a line."""
    scale = 0.95 * WIDTH / max(zero, value, 0.0 if math.isnan(high) else high)
    middle = HEIGHT / 2
    parts = [_rectangle(0.0, middle - 0.5, WIDTH, 1.0, PALE)]
    parts.append(_rectangle(zero * scale - 1.5, 4.0, 3.0, HEIGHT - 8.0, "fill-opacity='.5'"))
    if not math.isnan(low):
        parts.append(_rectangle(low * scale, middle - 1.5, (high - low) * scale, 3.0))
    parts.append(f"<circle cx='{value * scale:.1f}' cy='{middle:.1f}' r='6' fill='currentColor'/>")
    return _svg("".join(parts), f"error {value:.2g}, zero {zero:.2g}")


def _rectangle(x: float, y: float, width: float, height: float, style: str = "") -> str:
    place = f"x='{x:.1f}' y='{y:.1f}' width='{width:.1f}' height='{height:.1f}'"
    return f"<rect {place} fill='currentColor' {style}/>"


def _svg(content: str, label: str) -> str:
    return (
        f"<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {WIDTH:.0f} {HEIGHT:.0f}' "
        f"role='img' aria-label={quoteattr(label or 'nothing to show')}>{content}</svg>"
    )

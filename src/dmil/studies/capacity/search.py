"""The search for the highest load that stays stable: levels first, then bisection."""

from __future__ import annotations

from collections.abc import Callable, Sequence


def loads_tried(
    stable: Callable[[float], bool], highest: float, levels: int, halvings: int
) -> list[float]:
    """Try loads until the highest stable one is known closely; return them in order (ours).

    Loads rise level by level to the first that is not stable; between it and the last stable one
    the interval is halved. Higher levels are not tried: they hold the same vehicles and more.

    Parameters
    ----------
    stable
        Runs a load, and tells whether it is stable.
    highest
        Load of the last level.
    levels
        Number of levels, evenly spaced from 0, which is not tried.
    halvings
        Number of bisections; the result is known to highest / levels / 2^halvings.
    """
    tried: list[float] = []
    low = 0.0
    for level in range(1, levels + 1):
        high = highest * level / levels
        tried.append(high)
        if not stable(high):
            break
        low = high
    else:
        return tried
    for _ in range(halvings):
        middle = (low + high) / 2
        tried.append(middle)
        if stable(middle):
            low = middle
        else:
            high = middle
    return tried


def highest_stable(
    loads: Sequence[float], growth: Sequence[float], tolerance: float
) -> tuple[float, bool]:
    """Return the highest load of a search that was stable, 0 if none was (ours).

    Parameters
    ----------
    loads, growth
        Every load that was tried, and how the queue grew, see `dmil.statistics.queue_growth`.
    tolerance
        Growth that still counts as none.

    Returns
    -------
    The load, and whether all loads were stable, so that the capacity is at least that.
    """
    stable = [load for load, grew in zip(loads, growth, strict=True) if grew <= tolerance]
    return max(stable, default=0.0), len(stable) == len(loads)

"""A few picks and places of sample scenes, planned like the three hundred of `make bars BARS=robot`; takes seconds."""

from pathlib import Path

from bars.pick_place import is_counted, is_solved, motions_of, plan_scene
from server import Problem

PICKS_AND_PLACES, SEED = 2, 5


def check(lab: Path, bundles: list) -> str:
    """A line about the sample; a problem if a motion is missed, or there is none."""
    planned = 0
    for bundle in bundles:
        motions = motions_of(plan_scene(lab, bundle, SEED, PICKS_AND_PLACES))
        planned += len(motions)
        missed = [motion for motion in motions if is_counted(motion) and not is_solved(motion)]
        if missed:
            raise Problem("; ".join(f"{m['kind']} of {m['problem']} in {bundle.name}: {m['detail']}" for m in missed))
    if planned == 0:
        raise Problem(f"no motion in {', '.join(bundle.name for bundle in bundles)}")
    return f"{planned} motions planned among hulls, all free"

"""M1 of Al-Wagih & Abdulla: the Benedict-Bordner gains of one fixed alpha, held for the whole run."""

from tracker_core.adaptive.base import Method, Problem, Selection
from tracker_core.adaptive.scheduled import run_schedule
from tracker_core.design import DESIGNS


def work(problem: Problem, *, fixed_alpha: float) -> Selection:
    """The same gains at every sample."""
    gains = DESIGNS["benedict-bordner"].gains(2, alpha=fixed_alpha)
    return run_schedule(problem, lambda _, counts: gains.reshape(1, 2).repeat(len(counts), axis=0))


METHOD = Method(
    name="benedict-bordner",
    title="Benedict–Bordner at a fixed α (M1)",
    orders=(2,),
    parameters={"fixed_alpha": 0.05},
    work=work,
    sentence="α stays as it is, β = α²/(2 − α).",
    source="Al-Wagih & Abdulla, eq. 23, method M1",
)

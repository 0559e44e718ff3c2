"""What the commands of `companion mission` share: the transfer shown, a plan in words."""

from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

from companion.mission.items import Plan
from companion.mission.transfer import ShowTransfer


@contextmanager
def transfer_bar(console: Console) -> Iterator[ShowTransfer]:
    """Shows what is transferred, and how much of it is."""
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task("connecting", total=None)
        yield lambda what, done, total: bar.update(task, description=what, completed=done, total=total)


def summary(plan: Plan) -> str:
    """What a plan holds, in one line."""
    kinds = Counter(item.name for item in plan.mission)
    items = ", ".join(f"{count} {name}" for name, count in kinds.most_common())
    areas = len(plan.fence.polygons) + len(plan.fence.circles)
    parts = [f"{len(plan.mission)} items" + (f" ({items})" if items else "")]
    parts += [f"{areas} fence areas"] if areas else []
    parts += [f"{len(plan.rally)} rally points"] if plan.rally else []
    return ", ".join(parts)


def counts(plan: Plan) -> dict[str, int]:
    """How much a plan holds, for results."""
    return {
        "items": len(plan.mission),
        "fence_areas": len(plan.fence.polygons) + len(plan.fence.circles),
        "rally_points": len(plan.rally),
    }

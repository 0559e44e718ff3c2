"""`companion bench quadrotor`: the paper's flights and their figures."""

import shlex
import sys
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import track

from companion import __version__
from companion.cli import options
from companion.cli.lines import show
from companion.cli.result_file import write_result
from companion.errors import InputError
from companion.flight.strategies import Strategy
from companion.trajectory.placement import Placement

try:
    from companion.experiments.comparison import failures, flights, means, rms_errors
    from companion.experiments.contenders import lookahead_of
    from companion.experiments.lasa import BENCHMARK_NAMES
    from companion.experiments.quadrotor import paper_comparison, rows_and_summary, summary_table
    from companion.experiments.report import write_report
    from companion.experiments.results import results_table
    from companion.experiments.trajectories import courses
except ModuleNotFoundError as missing:
    raise InputError(
        f"the benchmark needs {missing.name}, which is not installed: pip install 'impromptu[bench]'"
    ) from missing


def quadrotor(
    trajectories: Annotated[
        list[str] | None,
        typer.Option(
            help="CSV files, drawings of config/trajectories or LASA shapes, as many as you like. "
            "Default: ten LASA shapes that nothing was tuned on."
        ),
    ] = None,
    source: Annotated[
        str, typer.Option(help="Vehicle whose network is used: a name in config/vehicles, or a YAML file.")
    ] = "ardrone2",
    target: Annotated[
        str, typer.Option(help="Vehicle that is flown: a name in config/vehicles, or a YAML file.")
    ] = "bebop2",
    model: Annotated[
        str | None,
        typer.Option(
            help="The source's network: a name in config/models, a file, or auto for all that ship but the "
            "target's own, of which dnn+gp takes what helps."
        ),
    ] = None,
    strategies: Annotated[
        str, typer.Option(help="Which to fly, with commas between; baseline is always flown.")
    ] = ",".join(Strategy),
    conditions: options.Conditions = "ideal",
    preset: options.PresetOption = options.Preset.DEFAULT,
    settings: options.SettingsFile = None,
    size: options.Size = 3.0,
    speed: Annotated[
        list[float] | None, typer.Option(help="Peak speeds (m/s), each flown; 1.2 for drawings.")
    ] = None,
    plane: options.PlaneOption = options.Plane.XZ,
    seed: options.Seed = 0,
    json: options.Json = None,
    report: options.PageDirectory = None,
) -> None:
    """Repeat the paper's flights: one vehicle's inverse network and the online correction on another vehicle.

    Errors are against the truth of the simulation, in the conditions px4 against the estimate. A flight
    that fails is a row with its reason.

    Example: companion bench quadrotor --json quadrotor.json

    Example: companion bench quadrotor --speed 0.6 1.2 2.0 --strategies feedforward,lookahead,dnn+gp

    Example: companion bench quadrotor --trajectories a.csv b.csv --conditions realistic --report reports/mine
    """
    if json is not None:
        options.writable(json)
    chosen, online = _chosen(strategies), options.online_settings(preset, settings)
    names = trajectories or list(BENCHMARK_NAMES)
    placement = Placement(size_m=size, plane=plane.value)
    drawings, slowed = courses(names, placement, [source, target], speed or [])
    console = Console()
    with console.status("Preparing the simulator (half a minute the first time) and measuring the lookahead"):
        comparison, notes = paper_comparison(
            [drawing.trajectory for drawing in drawings],
            source=source,
            target=target,
            model=model,
            strategies=chosen,
            conditions=conditions,
            seed=seed,
            online=online,
        )
    results = dict(track(comparison.fly(), "Flying", len(comparison), console=console, transient=True))
    figures = rows_and_summary(drawings, comparison.contenders, results)
    notes += slowed + failures(results)
    of_strategies = {flight: result for flight, result in results.items() if flight[1] in list(Strategy)}
    console.print(
        results_table(rms_errors(of_strategies)), summary_table(means(comparison.contenders, results))
    )
    show(console, *notes, style="yellow")
    if json is not None:
        asked = {
            "source": source,
            "target": target,
            "model": model,
            "trajectories": names,
            "strategies": chosen,
            "conditions": conditions,
            "preset": preset,
            "settings": None if settings is None else online.model_dump(mode="json"),
            "size_m": size,
            "speed_m_s": speed,
            "plane": plane,
            "seed": seed,
            "lookahead_s": lookahead_of(comparison.contenders),
        }
        write_result(figures | {"settings": asked, "notes": notes, "software": __version__}, json)
    if report is not None:
        page = write_report(
            flights(of_strategies),
            report,
            title=f"{target} with the network of {source}",
            conditions={
                "conditions": conditions,
                "preset": preset if settings is None else f"{preset}, but for {settings}",
                "seed": str(seed),
            },
            commands=[shlex.join(["companion", *sys.argv[1:]])],
        )
        show(console, f"report: {page}")


def _chosen(strategies: str) -> list[Strategy]:
    try:
        return [Strategy(name.strip()) for name in strategies.split(",")]
    except ValueError as error:
        raise InputError(f"--strategies: {error}; there are {', '.join(Strategy)}") from error

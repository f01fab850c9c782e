"""Makes the pictures of README and docs, and the tables that come from the code, from the program: `make pictures`.

Report figures are drawn by the report's own functions; the viewer's pictures are screenshots of rerun on a recording.
Where the viewer cannot start, one line says so and its pictures stay as they are.
"""

from __future__ import annotations

import contextlib
import io
import os
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import artwork
import matplotlib
import method
import numpy as np
import rerun_cli
import shown
import tables
import verdicts
from matplotlib.figure import Figure as MplFigure
from native_logs import LOGS
from PIL import Image
from rerun.experimental import ViewerClient

import magbench
from recordings import read_run
from reports.outputs.run import run_scenario
from reports.plots.calibration import draw_strength_before_after
from reports.plots.style import STYLE
from sim.scenario import load

PICTURES = Path(__file__).parent / "pictures"
WIDTH_PX, COLOURS, MOST_BYTES = 1400, 256, 200_000
PORT, MOST_WAIT_S, BAR_PX = 9897, 300.0, 36
EYE = np.array([-0.45, -0.6, 0.55])
"""From the middle of the path to the eye, in lengths of the path's diagonal."""


@dataclass(frozen=True)
class View:
    """The viewer on a scenario's recording at a moment; `phases`: what the path's eye sees, none for the whole."""

    file: str
    scenario: str
    time_s: float
    phases: tuple[str, ...] = ()


VIEWS = (
    View("viewer-auv-dive.png", "auv-dive", 9_500.0, ("spiral", "comb")),
    View("viewer-quad-comb.png", "quad-comb", 170.0),
)


def main() -> None:
    """The verdicts' pictures; every run once, its figures, its views; the tables; and what all of these show."""
    for verdict, found in verdicts.diagnosed().items():
        save(f"verdict-{verdict}.png", drawn(partial(verdicts.PICTURES[verdict], found)))
    with tempfile.TemporaryDirectory() as folder:
        for name in dict.fromkeys(picture.scenario for picture in (*shown.FIGURES, *VIEWS)):
            place = Path(folder) / name
            outcome = run_scenario(load(name), place)
            for figure in shown.FIGURES:
                if figure.scenario == name:
                    save(figure.file, drawn(partial(figure.draw, outcome)))
        save(shown.COVERAGE.file, drawn(partial(shown.COVERAGE.draw, Path(folder) / shown.COVERAGE.scenario)))
        viewed = dict(look(Path(folder), VIEWS))
    save("log-strength.png", drawn(log_strength))
    for name, draw in method.PICTURES.items():
        save(name, drawn(draw), method.MOST_BYTES)
    artwork.main()
    tables.write_all()
    shown.keep(verdicts.kept(), method.kept(), viewed)


def log_strength() -> MplFigure:
    """The strength of the docs' own log before and after its calibration."""
    found = magbench.calibrate(str(LOGS / "flight.bin"), with_="motor_ellipsoid:battery")
    strength_nT = found.reference.strength_nT
    return draw_strength_before_after(found.recording.time_s, found.recording.mag_nT, found.corrected_nT, strength_nT)


def drawn(draw: Callable[[], MplFigure]) -> bytes:
    """A report's figure as PNG."""
    file = io.BytesIO()
    with matplotlib.rc_context(STYLE):
        figure = draw()
        figure.savefig(file, format="png", dpi=WIDTH_PX / figure.get_figwidth())
    return file.getvalue()


def save(name: str, png: bytes, most_bytes: int = MOST_BYTES) -> None:
    """Write a PNG no wider than WIDTH_PX, in as many colours as its size allows."""
    image = Image.open(io.BytesIO(png)).convert("RGB")
    if image.width > WIDTH_PX:
        image = image.resize((WIDTH_PX, round(image.height * WIDTH_PX / image.width)), Image.Resampling.LANCZOS)
    colours = COLOURS
    while True:
        file = io.BytesIO()
        image.quantize(colours, Image.Quantize.MAXCOVERAGE, kmeans=8, dither=Image.Dither.NONE).save(
            file, format="png", optimize=True
        )
        if file.tell() <= most_bytes or colours <= 16:
            break
        colours //= 2
    (PICTURES / name).write_bytes(file.getvalue())
    print(f"{name}: {file.tell() // 1000} kB")


def look(folder: Path, views: Iterable[View]) -> Iterator[tuple[str, str]]:
    """Screenshots of the viewer, without a display; file and scenario of each that is made."""
    program = Path(next(iter(rerun_cli.__path__))) / "rerun"
    try:
        with (
            silent(),
            ViewerClient.spawn(
                headless=True, port=PORT, executable_path=str(program), hide_welcome_screen=True
            ) as viewer,
        ):
            for view in views:
                viewer.open(str(folder / view.scenario / "recording.rrd"))
                settled(viewer)
                viewer.set_time("time", duration=view.time_s)
                if view.phases:
                    aim(viewer, folder / view.scenario, view)
                save(view.file, cropped(settled(viewer)))
                yield view.file, view.scenario
                viewer.close("all")
    except (RuntimeError, OSError, ConnectionError) as error:
        reason = str(error).strip().splitlines()[0]
        do = "it needs a Vulkan driver: apt-get install mesa-vulkan-drivers"
        print(f"pictures of the viewer are not made: the rerun viewer does not start ({reason}); {do}", file=sys.stderr)


@contextlib.contextmanager
def silent() -> Iterator[None]:
    """Without the viewer's own log, which it writes to this process's standard error."""
    kept = os.dup(2)
    with open(os.devnull, "w") as nowhere:
        os.dup2(nowhere.fileno(), 2)
    try:
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)


def settled(viewer: ViewerClient) -> bytes:
    """A screenshot once two in a row are the same."""
    last, end = b"", time.monotonic() + MOST_WAIT_S
    while time.monotonic() < end:
        time.sleep(2.0)
        now = viewer.take_screenshot()
        if now == last:
            return now
        last = now
    raise RuntimeError("the picture does not come to rest")


def cropped(png: bytes) -> bytes:
    """The screenshot without the window's own bar."""
    image, file = Image.open(io.BytesIO(png)), io.BytesIO()
    image.crop((0, BAR_PX, image.width, image.height)).save(file, format="png")
    return file.getvalue()


def aim(viewer: ViewerClient, place: Path, view: View) -> None:
    """Turn the path's eye to some phases."""
    recording, truth = read_run(place)
    assert recording.phase is not None
    pos_m = truth.pos_enu_m[np.isin(recording.phase, view.phases)]
    low, high = pos_m.min(axis=0), pos_m.max(axis=0)
    target = (low + high) / 2
    layout: dict[str, Any] = viewer.get_blueprint().blueprint
    path = next(key for key, value in layout.items() if value.get("ViewBlueprint", {}).get("display_name") == "Path")
    position = target + EYE * float(np.linalg.norm(high - low))
    layout[f"{path}/EyeControls3D"] = {"EyeControls3D": {"look_target": target.tolist(), "position": position.tolist()}}
    viewer.set_blueprint(layout, of="recording")


if __name__ == "__main__":
    main()

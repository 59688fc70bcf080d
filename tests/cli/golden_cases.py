"""Commands whose JSON is written down in `golden`, and how what they say is compared.

Words, paths and numbers: {resources} is the program's own folder of data, {specimens} that of
tests/specimens (copied, so that nothing can be written there), {work} an empty folder that the
cases share.
"""

from __future__ import annotations

import contextlib
import io
import json
import math
import re
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
GOLDEN = Path(__file__).resolve().parent / "golden"
SPECIMENS = ROOT / "tests" / "specimens"

TOLERANCE = 1e-9
"""Relative; numbers below it are nothing."""
TOLERANCES = {
    # Decoded by a library, whose versions differ in the last bit of a pixel.
    "blur": 2e-2,
    "sharpness": 2e-2,
    "overlap": 2e-2,
    "shift": 2e-2,
    "brightness": 1e-2,
    "views": 5e-2,
    # Pixels at the border of what is seen.
    "coverage": 1e-3,
    # Picked by a search tree, sampled.
    "resolution_m": 1e-6,
    "resolution": 1e-6,
}
"""By the key of the nearest object, where numbers depend on versions of libraries."""


@dataclass(frozen=True)
class Case:
    """after : cases whose files it reads. like : what is compared is the kind of every value only,
    since the numbers differ from machine to machine. slow : more than some seconds"""

    name: str
    words: str
    after: tuple[str, ...] = ()
    code: int = 0
    like: bool = False
    slow: bool = False


CASES = (
    Case("demo", "demo --without-photos -o {work}/demo"),
    Case("demo-refused", "demo --without-photos -o {work}/used", code=2),
    Case(
        "info-models",
        "info {resources}/sample/sample.obj {resources}/outcrop/outcrop.obj {specimens}/boulder.ply"
        " {specimens}/schema1.vom/models/face/face.obj"
        " {specimens}/schema1.vom/reconstruction/photos-preview/sparse.ply",
    ),
    Case(
        "info-tables",
        "info {resources}/sample/picks.csv {specimens}/photos/control.csv"
        " {specimens}/photos/marks.csv {work}/planes.csv {work}/lines.csv",
        after=("fit-by",),
    ),
    Case("info-photos", "info {specimens}/photos {specimens}/photos/HL_2041.jpg"),
    Case(
        "info-made",
        "info {work}/ortho.tif {work}/ortho_depth.tif {work}/face.glb {work}/boulder.laz",
        after=("ortho-fold", "convert-glb", "convert-laz"),
    ),
    Case("info-some-refused", "info {specimens}/boulder.ply {work}/gone.obj {work}/used", code=2),
    Case(
        "convert-glb",
        "convert {specimens}/schema1.vom/models/face/face.obj {work}/face.glb --crs EPSG:32633",
    ),
    Case(
        "convert-laz",
        "convert {specimens}/boulder.ply {work}/boulder.laz --up y --unit ft",
    ),
    Case("convert-xyz", "convert {resources}/outcrop/outcrop.obj {work}/outcrop.xyz"),
    Case("convert-refused", "convert {specimens}/boulder.ply {work}/boulder.docx", code=2),
    Case("fit-by", "fit {resources}/sample/picks.csv --by pick -o {work}/planes.csv"),
    Case("fit-regression", "fit {resources}/outcrop/picks.csv --by trace --method regression"),
    Case("fit-together", "fit {resources}/outcrop/picks.csv"),
    Case("fit-some-skipped", "fit {work}/short.csv --by part"),
    Case("register", "register - --pairs {work}/pairs.csv"),
    Case("register-refused", "register - --pairs {work}/three.csv", code=2),
    Case(
        "register-reference",
        "register {specimens}/schema1.vom/models/face/face.obj"
        " --reference {specimens}/schema1.vom/models/face/face.obj",
        like=True,
    ),
    Case("compare", "compare {specimens}/boulder.ply {specimens}/boulder.ply -o {work}/same.ply"),
    Case(
        "compare-m3c2",
        "compare {work}/above.xyz {work}/ground.xyz --m3c2 0.4 --registration-error 0.01",
    ),
    Case(
        "facets",
        "facets {resources}/sample/sample.obj -o {work}/facets.csv --labels {work}/facets.ply"
        " --max-distance 0.05 --min-area 0.5",
        like=True,
    ),
    Case(
        "extend",
        "extend {specimens}/schema1.vom/models/face/face.obj --plane 110/40 --error 2"
        " --through 364534,4721858,852 --thickness 2 -o {work}/beds.csv",
    ),
    Case(
        "extend-refused",
        "extend {specimens}/boulder.ply --plane 20/90 -o {work}/none.csv",
        code=2,
    ),
    Case("surface", "surface {work}/slope.csv -o {work}/slope.tif --profiles {work}/profiles.csv"),
    Case(
        "measurable",
        "measurable {specimens}/boulder.ply --plane 20/60 -o {work}/map.tif",
        like=True,
    ),
    Case("measurable-refused", "measurable {specimens}/boulder.ply", code=2),
    Case("surface-refused", "surface {work}/slope.csv -o {work}/slope.png", code=2),
    Case(
        "facets-refused", "facets {resources}/sample/sample.obj -o {work}/f.csv --angle 90", code=2
    ),
    Case(
        "trace", "trace {work}/slope.csv --through {work}/clicks.csv -o {work}/bed.csv --cost grey"
    ),
    Case("trace-proposed", "trace {work}/slope.csv --propose -o {work}/seen.csv --cost grey"),
    Case(
        "trace-proposed-refused",
        "trace {work}/slope.csv --propose -o {work}/none.csv --cost dark",
        code=2,
    ),
    Case(
        "trace-refused",
        "trace {work}/slope.csv --through {work}/ground.xyz -o {work}/none.csv --cost shade",
        code=2,
    ),
    Case(
        "compare-orientations",
        "compare {work}/above.xyz {work}/ground.xyz --orientations {work}/planes.csv "
        "{work}/planes.csv",
        after=("fit-by",),
    ),
    Case("compare-refused", "compare {work}/above.xyz {resources}/sample/sample.obj", code=2),
    Case("fit-parallel", "fit {resources}/sample/picks.csv --by pick --parallel --same B01,B02"),
    Case("fit-curved", "fit {resources}/sample/picks.csv --by pick --curved"),
    Case("fit-parallel-refused", "fit {work}/three.csv --same a,b", code=2),
    Case("fit-refused", "fit {work}/broken.csv", code=2),
    Case("stats-sets", "stats {work}/planes.csv --by kind", after=("fit-by",)),
    Case("stats-project", "stats {work}/project.csv --by set", after=("export-csv",)),
    Case("stats-directed", "stats {work}/lines.csv --directed"),
    Case("stats-refused", "stats {work}/azimuths.csv", code=2),
    Case("fold", "fold {work}/planes.csv", after=("fit-by",)),
    Case("fold-joints", "fold {work}/project.csv --kind joint", after=("export-csv",)),
    Case("fold-sets", "fold {work}/three.csv --sets hanging,foot,fault"),
    Case("fold-domains", "fold {work}/three.csv --by set"),
    Case("fold-refused", "fold {work}/lines.csv", code=2),
    Case("stereonet", "stereonet {work}/planes.csv --by kind -o {work}/net.svg", after=("fit-by",)),
    Case(
        "stereonet-contours",
        "stereonet {work}/planes.csv --contour kamb --projection angle -o {work}/net.png",
        after=("fit-by",),
    ),
    Case(
        "stereonet-each-set",
        "stereonet {work}/planes.csv --by kind --contour exponential_kamb --levels 2,6"
        " --each-set -o {work}/each.svg",
        after=("fit-by",),
    ),
    Case("rose", "rose {work}/planes.csv --by kind --bin 30 -o {work}/rose.svg", after=("fit-by",)),
    Case(
        "stereonet-asked",
        "stereonet {work}/planes.csv --by kind --girdles --maxima --averages --errors"
        " --slip-line 120/60/40 --untilt 100/10 --grey --size 120x100 -o {work}/asked.svg",
        after=("fit-by",),
    ),
    Case(
        "rose-dip",
        "rose {work}/planes.csv --by kind --of dip --bin 15 -o {work}/dips.svg",
        after=("fit-by",),
    ),
    Case("threepoint", "threepoint {work}/seam.txt --sigma 5"),
    Case("threepoint-refused", "threepoint {work}/seam.txt --sigma -5", code=2),
    Case("log", "log {work}/log.csv --bed 90/30 --sigma 0.01 --bed-error 2 -o {work}/log_beds.csv"),
    Case("log-refused", "log {work}/log.csv --bed 90/95", code=2),
    Case("rose-refused", "rose {work}/planes.csv --bin 7 -o {work}/roses.svg", code=2),
    Case("slope", "slope {work}/planes.csv --face 310/75 --friction 35", after=("fit-by",)),
    Case("repeats", "repeats {work}/repeats.csv"),
    Case("repeats-refused", "repeats {work}/planes.csv", after=("fit-by",), code=2),
    Case("slip", "slip {work}/faults.txt"),
    Case("slip-refused", "slip {work}/planes.csv", after=("fit-by",), code=2),
    Case(
        "slope-facets",
        "slope {work}/planes.csv --facets {work}/planes.csv --friction 35 -o {work}/facets_s.csv",
        after=("fit-by",),
    ),
    Case("slope-refused", "slope {work}/planes.csv --face 310/0 --friction 35", code=2),
    Case(
        "displacement",
        "displacement {work}/cutoffs.csv --fault 90/60 --bed 270/10 --rake 80"
        " --sigma 0.05 --bed-error 3",
    ),
    Case("displacement-separation", "displacement {work}/cutoffs.csv --fault 90/60 --bed 270/10"),
    Case("displacement-refused", "displacement {work}/cutoffs.csv --fault 90/60 --rake 80", code=2),
    Case("sets", "sets {work}/three.csv -o {work}/sets.csv"),
    Case("sets-seeds", "sets {work}/three.csv --seeds 90/30,105/70 -o {work}/seeded.csv"),
    Case("sets-refused", "sets {work}/lines.csv -o {work}/no_sets.csv", code=2),
    Case(
        "fractures",
        "fractures {work}/traces.geojson --area {work}/area.geojson --snap 0.01"
        " --plot {work}/fractures.svg",
    ),
    Case(
        "fractures-scanline",
        "fractures {work}/traces.geojson --scanline {work}/traces.geojson"
        " --strikes 80-100 --terzaghi-cap 3",
    ),
    Case("fractures-refused", "fractures {work}/three.csv", code=2),
    Case("stereonet-refused", "stereonet {work}/three.csv -o {work}/net.txt", code=2),
    Case(
        "ortho-fold",
        "ortho {specimens}/schema1.vom/models/face/face.obj --fold {work}/planes.csv --gsd 0.05"
        " --sheet {work}/sheet.png -o {work}/ortho.tif",
        after=("fit-by",),
    ),
    Case(
        "ortho-plane",
        "ortho {specimens}/schema1.vom/models/face/face.obj --plane 200/85 --gsd 0.1 --flip"
        " -o {work}/plane.tif",
    ),
    Case(
        "ortho-cloud",
        "ortho {specimens}/boulder.ply --trend 40 --plunge 90 --up y --unit ft --gsd 0.05"
        " -o {work}/cloud.tif",
    ),
    Case(
        "dem",
        "dem {specimens}/schema1.vom/models/face/face.obj --plane 200/85 --gsd 0.1 --slope"
        " -o {work}/dem.tif",
    ),
    Case("dem-cloud", "dem {specimens}/boulder.ply --up y --gsd 0.05 -o {work}/dem-cloud.tif"),
    Case("dem-refused", "dem {specimens}/boulder.ply --limit 0 -o {work}/none.tif", code=2),
    Case(
        "section",
        "section {specimens}/schema1.vom/models/face/face.obj --plane 110/90"
        " --through 364534,4721858,852 -o {work}/section.svg",
    ),
    Case(
        "section-refused",
        "section {specimens}/boulder.ply --plane 20/90 -o {work}/none.svg",
        code=2,
    ),
    Case(
        "ortho-draw",
        "ortho {specimens}/schema1.vom/models/face/face.obj --trend 31 --plunge 11 --gsd 0.1"
        " --draw {specimens}/schema1.vom -o {work}/drawn.tif",
    ),
    Case(
        "trace-drawing",
        "trace {specimens}/schema1.vom/models/face/face.obj"
        " --from-ortho {work}/drawn_drawing.gpkg --sidecar {work}/drawn.json -o {work}/drawn.csv",
        after=("ortho-draw",),
    ),
    Case(
        "trace-drawing-refused",
        "trace {specimens}/boulder.ply --from-ortho {work}/planes.csv -o {work}/none.csv",
        code=2,
    ),
    Case("ortho-refused", "ortho {specimens}/boulder.ply -o {work}/none.tif", code=2),
    Case(
        "plan",
        "plan --camera 23.5x15.6,35,6000x4000 --distance 20 --width 30 --height 10"
        " -o {work}/plan.svg",
    ),
    Case(
        "plan-drone",
        "plan --camera {specimens}/photos/HL_2041.jpg --gsd 0.02 --width 14 --height 6"
        " --manner drone --overlap 0.8",
    ),
    Case("plan-refused", "plan --camera Brownie --distance 3 --width 9 --height 3", code=2),
    Case("check", "check {specimens}/photos --distance 15"),
    Case(
        "check-aligned",
        "check {specimens}/photos --scene"
        " {specimens}/schema1.vom/reconstruction/photos-preview/work/{frame}",
    ),
    Case("check-refused", "check {work}/used", code=2),
    Case("frames", "frames {work}/pan.avi -o {work}/frames --fps 2"),
    Case("frames-refused", "frames {work}/broken.csv -o {work}/none", code=2),
    Case("project-list", "project {specimens}/schema1.vom list"),
    Case("project-fit", "project {specimens}/schema1.vom fit B01 L04"),
    Case("project-verify", "project {specimens}/schema1.vom verify"),
    Case("project-refused", "project {work}/none.vom list", code=2),
    Case("export-csv", "export {specimens}/schema1.vom --to csv -o {work}/project.csv"),
    Case("export-orient", "export {specimens}/schema1.vom --to orient -o {work}/orient.tsv"),
    Case("export-kml", "export {specimens}/schema1.vom --to kml -o {work}/map.kml", code=2),
    Case("export-gpkg", "export {specimens}/schema1.vom --to gpkg -o {work}/project.gpkg"),
    Case("export-shp", "export {specimens}/schema1.vom --to shp -o {work}/project.shp"),
    Case("export-dxf", "export {specimens}/schema1.vom --to dxf -o {work}/project.dxf"),
    Case("export-refused", "export {work}/used --to csv -o {work}/none.csv", code=2),
    Case(
        "reconstruct",
        "reconstruct {specimens}/photos -o {work}/model --quality preview --threads 1",
        like=True,
        slow=True,
    ),
    Case("reconstruct-refused", "reconstruct {work}/used -o {work}/none", code=2),
    Case(
        "reconstruct-without-marks",
        "reconstruct {specimens}/photos -o {work}/none --gcp {specimens}/photos/control.csv"
        " --marks {work}/gone.csv",
        code=2,
    ),
    Case("completion", "completion bash"),
    Case("completion-refused", "completion tcsh", code=2),
    Case("no-command", "", code=2),
    Case("unknown-command", "dance", code=2),
    Case("wrong-option", "fit {work}/three.csv --wrong", code=2),
    Case("project-report", "project {specimens}/schema1.vom report -o {work}/report.html"),
    # It opens the project, which brings its journal up to date.
    Case("project-coverage", "project {specimens}/schema1.vom coverage"),
)


# --- running --------------------------------------------------------------------------------------
def prepare(folder: Path) -> dict[str, str]:
    """Make the small inputs of the cases below `folder`; what the words in braces stand for."""
    from vomstudio.core.paths import resource

    work, specimens = folder / "work", folder / "specimens"
    work.mkdir(parents=True)
    specimens.mkdir()
    for name in ("schema1.vom", "photos"):
        shutil.copytree(SPECIMENS / name, specimens / name)
    shutil.copy(SPECIMENS / "boulder.ply", specimens)
    (work / "used").mkdir()
    (work / "used" / "notes.txt").write_text("not to be touched\n")
    (work / "broken.csv").write_text("x,y,z\n1,2,3\n4,five,6\n7,8,9\n")
    (work / "short.csv").write_text(
        "x,y,z,part\n"
        + "".join(f"{x},{y},{0.3 * x + 0.1 * y * y},a\n" for x in range(4) for y in range(3))
        + "0,0,0,b\n1,1,1,b\n"
    )
    (work / "repeats.csv").write_text(
        "id,dip_direction,dip,max_confidence95_deg,repeat_of,interpreter\na,90,40,3,,AB\n"
        "b,100,50,3,,AB\nc,120,60,2,,AB\nd,90,43,3,a,AB\ne,101,52,3,b,CD\nf,99,53,3,zz,CD\n"
    )
    (work / "faults.txt").write_text(
        "strike\tdip\ttrend\tplunge\tsense\n20\t60\t100\t59.6\tNL\n195\t55\t290\t54.9\tNR\n"
        "10\t70\t102\t70\tN\n100\t88\t101\t10\tL\n30\t50\t\t\tN\n"
    )
    (work / "pairs.csv").write_text(
        "label,model_x,model_y,model_z,x,y,z,use\nA,0,0,0,100,200,50,\nB,9,0,0,100.01,218,50,\n"
        "C,0,8,1,84,200.02,52,\nD,3,2,7,96,206,64.02,\nE,5,6,0.5,88,210,51.01,check\n"
    )
    for name, up in (("ground", 0.0), ("above", 0.05)):
        rows = [(k % 20 / 10, k // 20 / 10, up + (k * k % 7 - 3) / 100) for k in range(400)]
        (work / f"{name}.xyz").write_text("".join(f"{x} {y} {z:.2f}\n" for x, y, z in rows))
    y, x = (axis.ravel() * 0.05 for axis in np.mgrid[0:40, 0:60])
    z = 0.5 * y + 0.2 * np.sin(2.0 * x)
    (work / "slope.csv").write_text(
        "x,y,z,grey\n"
        + "".join(
            f"{a:.2f},{b:.2f},{c:.4f},{10 if abs(c - 0.5) < 0.05 else 200}\n"
            for a, b, c in zip(x, y, z, strict=True)
        )
    )
    (work / "clicks.csv").write_text("x,y,z\n0.05,0.95,0.49\n1.5,0.95,0.5\n2.9,1.2,0.51\n")
    (work / "azimuths.csv").write_text("azimuth,dip\n10,20\n30,40\n50,60\n")
    (work / "lines.csv").write_text(
        "name,trend,plunge\nL1,10,20\nL2,15,-12\nL3,22,18\nL4,355,25\nL5,12,8\n"
    )
    (work / "three.csv").write_text(
        "set,dip_direction,dip\n"
        + "".join(f"hanging,{90 + k},{30 + k % 3}\n" for k in range(6))
        + "".join(f"foot,{270 - k},{40 + k % 2}\n" for k in range(6))
        + "".join(f"fault,{100 + 2 * k},{70 - k % 3}\n" for k in range(6))
    )
    write_traces(work)
    (work / "seam.txt").write_text("393 2374 550\n1891 2738 650\n2191 1037 450\n")
    (work / "log.csv").write_text(
        "name,x,y,z,lithology,notes\na,0,0,0,sandstone,coarse\nb,10,0,0,lime mudstone,\n"
        "c,20,2,1,,\n"
    )
    (work / "cutoffs.csv").write_text(
        "name,hanging_x,hanging_y,hanging_z,footwall_x,footwall_y,footwall_z\n"
        "A,104.6,50.2,81.1,100,50,90\nB,115.2,71.1,78.9,110,70,88\n"
    )
    write_film(work / "pan.avi")
    frame = next((specimens / "schema1.vom/reconstruction/photos-preview/work").glob("frame-*"))
    return {
        "work": str(work),
        "specimens": str(specimens),
        "resources": str(resource("sample").parent),
        "frame": frame.name,
    }


def write_traces(work: Path) -> None:
    """Two sets of traces in metres, one abutting on the other, and the area around them."""
    lines = [[[0.5 * k, 0.3 * k], [0.5 * k + 7 + 0.7 * k % 3, 0.3 * k]] for k in range(12)]
    lines += [[[k, 0.3], [k, 0.9 + 0.2 * k]] for k in range(3, 9)]
    ring = [[1, -1], [9, -1], [9, 5], [1, 5], [1, -1]]
    for name, kind, shapes in (("traces", "LineString", lines), ("area", "Polygon", [[ring]])):
        features = [
            {"type": "Feature", "properties": {}, "geometry": {"type": kind, "coordinates": c}}
            for c in shapes
        ]
        crs = {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::32633"}}
        layer = {"type": "FeatureCollection", "crs": crs, "features": features}
        (work / f"{name}.geojson").write_text(json.dumps(layer))


def write_film(path: Path) -> None:
    """A camera that moves along a rough wall, stands still, and goes on."""
    import cv2

    chance = np.random.default_rng(5)
    wall = chance.integers(0, 256, (60, 400)).astype(np.uint8)
    wall = cv2.resize(wall, (2400, 360), interpolation=cv2.INTER_CUBIC)
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"MJPG"), 20, (480, 360))
    assert writer.isOpened()
    for x in [*range(0, 480, 12), *[480] * 20, *range(480, 960, 12)]:
        writer.write(cv2.cvtColor(wall[:, x : x + 480], cv2.COLOR_GRAY2BGR))
    writer.release()


class Runner:
    """Runs cases in this process, each once, after those whose files it reads."""

    def __init__(self, folder: Path) -> None:
        self.places = prepare(folder)
        self._ran: dict[str, dict[str, Any]] = {}
        self._cases = {case.name: case for case in CASES}

    def ran(self, name: str) -> dict[str, Any]:
        """Words, exit code and masked JSON of a case, as in its golden file."""
        if name not in self._ran:
            case = self._cases[name]
            for before in case.after:
                self.ran(before)
            self._ran[name] = self._run(case)
        return self._ran[name]

    def _run(self, case: Case) -> dict[str, Any]:
        from vomstudio.cli import main

        words = [word.format(**self.places) for word in case.words.split()]
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = main([*words, "--json"])
        assert out.getvalue().count("\n") == 1, err.getvalue()
        return {
            "command": f"vomstudio {case.words} --json",
            "code": code,
            "json": self.masked(json.loads(out.getvalue())),
        }

    # --- what differs from run to run ------------------------------------------------------------
    def masked(self, value: Any, key: str = "") -> Any:
        """With names in braces in place of folders, and without seconds, memory and versions."""
        if key == "seconds" and isinstance(value, dict):
            return {name: "<seconds>" for name in value}
        if key == "versions" and isinstance(value, dict):
            return {name: "<version>" for name in value}
        if isinstance(value, dict):
            made = {name: self.masked(item, name) for name, item in value.items()}
            if "content_hash" in made and str(made.get("path")).startswith("{work}"):
                # Of a file that names the version that wrote it.
                made["content_hash"] = "<hash>"
            return made
        if isinstance(value, list):
            return [self.masked(item, key) for item in value]
        if isinstance(value, str):
            return self._masked_text(value)
        if key in ("peak_memory_mb", "work_mb"):
            return "<megabytes>"
        return value

    def _masked_text(self, text: str) -> str:
        from vomstudio import __version__

        for name in ("work", "specimens", "resources"):
            place = self.places[name]
            for written in (place, place.replace("\\", "/"), str(Path(place).resolve())):
                text = text.replace(written, f"{{{name}}}")
        text = re.sub(r"frame-[0-9a-f]{16}", "{frame}", text)
        text = re.sub(r"\S+[\\/]images[\\/][0-9a-f]{32}", "{images}", text)
        return text.replace(f"VOM Studio {__version__}", "VOM Studio <version>")


# --- comparing ------------------------------------------------------------------------------------
def differences(was: Any, now: Any, where: str = "", key: str = "") -> Iterator[str]:
    """Sentences about what is not as it was written down."""
    if kind_of(was) != kind_of(now):
        yield f"{where}: {was!r} is {now!r} now"
    elif isinstance(was, dict):
        for name in was.keys() - now.keys():
            yield f"{where}.{name} is gone"
        for name in now.keys() - was.keys():
            yield f"{where}.{name} is new"
        for name in was.keys() & now.keys():
            yield from differences(was[name], now[name], f"{where}.{name}", name)
    elif isinstance(was, list):
        if len(was) != len(now):
            yield f"{where}: {len(was)} entries are {len(now)} now"
        for number, (one, other) in enumerate(zip(was, now, strict=False)):
            yield from differences(one, other, f"{where}[{number}]", key)
    elif isinstance(was, float):
        wide = TOLERANCES.get(key, TOLERANCE)
        if not math.isclose(was, now, rel_tol=wide, abs_tol=wide):
            yield f"{where}: {was!r} is {now!r} now"
    elif was != now:
        yield f"{where}: {was!r} is {now!r} now"


def kind_of(value: Any) -> str:
    """The kind of a JSON value; a whole number is another kind than a float, which has a point."""
    return "null" if value is None else type(value).__name__


def outline(value: Any) -> Any:
    """Keys and kinds only; of the entries of a list, all that occur."""
    if isinstance(value, dict):
        return {name: outline(item) for name, item in value.items()}
    if isinstance(value, list):
        found: list[Any] = []
        for item in value:
            if (each := outline(item)) not in found:
                found.append(each)
        return found
    return kind_of(value)


def golden(name: str) -> dict[str, Any]:
    """What is written down of a case."""
    found: dict[str, Any] = json.loads((GOLDEN / f"{name}.json").read_text(encoding="utf-8"))
    return found


def write_golden(name: str, ran: dict[str, Any]) -> None:
    text = json.dumps(ran, indent=1, ensure_ascii=False)
    (GOLDEN / f"{name}.json").write_text(text + "\n", encoding="utf-8")

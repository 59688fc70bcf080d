"""Groups and examples in the help of the commands."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterable

from vomstudio.core.words import to_translate, tr

INPUT = to_translate("input")
METHOD = to_translate("method")
COORDINATES = to_translate("coordinates")
FIGURE = to_translate("style of the figure")
OUTPUT = to_translate("output")
GENERAL = to_translate("general")
COMMANDS = to_translate("commands")
GROUPS = (COMMANDS, INPUT, METHOD, COORDINATES, FIGURE, OUTPUT, GENERAL)

_GENERAL_FLAGS = {"--help", "--json", "--progress", "--quiet", "--verbose", "--version"}
_GENERAL_FLAGS |= {"--install-desktop", "--uninstall-desktop"}
_COORDINATE_FLAGS = {"--up", "--unit", "--crs", "--to-crs", "--project"}
_OUTPUT_FLAGS = {
    "--output",
    "--force",
    "--plot",
    "--labels",
    "--sheet",
    "--draw",
    "--show",
    "--paint",
}
_OUTPUT_FLAGS |= {"--profiles", "--hillshade", "--slope", "--aspect", "--contours", "--into"}
_FIGURE_FLAGS = {
    "--font",
    "--font-size",
    "--line-width",
    "--grey",
    "--symbol-size",
    "--size",
    "--color",
}
_FILE_METAVARS = {
    "FILE",
    "TABLE",
    "MODEL",
    "FACETS",
    "POINTS",
    "DRAWING",
    "PHOTO",
    "POLYGON",
    "LINE",
}


def help_group(action: argparse.Action) -> str:
    """Return the group of the help in which an argument is listed.

    Parameters
    ----------
    action : argparse.Action

    Returns
    -------
    str
        One of `GROUPS`.
    """
    if isinstance(action, argparse._SubParsersAction):
        return COMMANDS
    if not action.option_strings:
        return INPUT
    flag = action.option_strings[-1]
    for group, flags in (
        (GENERAL, _GENERAL_FLAGS),
        (COORDINATES, _COORDINATE_FLAGS),
        (OUTPUT, _OUTPUT_FLAGS),
        (FIGURE, _FIGURE_FLAGS),
    ):
        if flag in flags:
            return group
    return INPUT if action.metavar in _FILE_METAVARS else METHOD


def group_actions(actions: Iterable[argparse.Action]) -> dict[str, list[argparse.Action]]:
    """Return the arguments by their group, in the order of the groups.

    Parameters
    ----------
    actions : iterable of argparse.Action

    Returns
    -------
    dict of list
        Groups without arguments are left out.
    """
    all_actions = list(actions)
    groups = {
        group: [action for action in all_actions if help_group(action) == group] for group in GROUPS
    }
    return {group: members for group, members in groups.items() if members}


def command_examples(program: str) -> tuple[str, ...]:
    """Return the examples of a command.

    Parameters
    ----------
    program : str
        Name of its parser, such as "vomstudio project PROJECT undo".

    Returns
    -------
    tuple of str
        Empty for the program itself and for other parsers without examples.
    """
    return EXAMPLES.get(program.removeprefix("vomstudio").replace(" PROJECT", "").strip(), ())


def examples_text(program: str) -> str:
    """Return the help section with the examples and the commands that create their input.

    Parameters
    ----------
    program : str
        Name of the parser of a command.

    Returns
    -------
    str
        Empty if the command has no examples.
    """
    examples = command_examples(program)
    if not examples:
        return ""
    lines = [
        tr("examples (run them in the program folder):"),
        *(f"  {example}" for example in examples),
    ]
    outputs = {
        name for example in examples for name in re.findall(r" (?:-o|--labels) (\S+)", example)
    }
    words = {word for example in examples for word in example.split()[1:]}
    for name, source in SOURCES.items():
        is_read = any(word == name or word.startswith(f"{name}/") for word in words)
        if is_read and name not in outputs:
            lines.append("  " + tr("to create {file}: {command}", file=name, command=source))
    lines += [f"  {name}: {tr(text)}" for name, text in USER_FILES.items() if name in words]
    return "\n".join(lines) + "\n"


_SAMPLE_MODEL = "resources/sample/sample.obj"
_PROJECT_COMMAND = "vomstudio project results/sample.vom"

_TIE_COLUMNS = "label,model_x,model_y,model_z,x,y,z"
_TABLES = {
    "seam.csv": "x,y,z 393,2374,550 1891,2738,650 2191,1037,450",
    "boundaries.csv": "x,y,z,lithology 0,0,0,sandstone 3,0,0,claystone 10,0,0,limestone",
    "faults.csv": "strike,dip,rake,sense 20,60,80,N 195,55,100,N 15,62,85,N",
    "pairs.csv": "hanging_x,hanging_y,hanging_z,footwall_x,footwall_y,footwall_z 5,0,-8.66,0,0,0",
    "repeated.csv": "strike,dip,bed 20,60,1 22,63,1 195,55,2 194,54,2",
    "points.csv": f"{_TIE_COLUMNS} A,0,0,0,500,100,20 B,9,0,0,500,118,20 C,0,8,1,484,100,22",
    "tie.csv": f"{_TIE_COLUMNS} A,364521,4721864,850,364521.1,4721864.3,850"
    " B,364547,4721855,848,364547.1,4721855.2,848 C,364534,4721860,858,364534.1,4721860.3,858",
    "way_points.csv": "x,y,z 364520.62,4721864.22,850.17 364522.57,4721864.28,851.22",
    "stations.csv": "name,x,y,z ST1,364521.66,4721864.89,850.38",
}
"""Small tables that examples read; lines are separated by spaces."""

SOURCES = {
    **{
        name: "printf '{}' >{}".format("".join(rf"{row}\n" for row in rows.split()), name)
        for name, rows in _TABLES.items()
    },
    "planes.csv": "vomstudio fit resources/sample/picks.csv --by pick -o planes.csv",
    "facets.csv": f"vomstudio facets {_SAMPLE_MODEL} -o facets.csv",
    "results": "vomstudio demo --without-photos -o results",
    "model": "vomstudio reconstruct resources/sample/photos --quality preview -o model",
}
"""Files that examples read, with the commands that write them."""

USER_FILES = {"walk.mp4": to_translate("a video of the outcrop")}
"""Files that the user must provide for an example."""

EXAMPLES: dict[str, tuple[str, str]] = {
    "demo": (
        "vomstudio demo --without-photos -o results",
        "vomstudio demo -o results_with_photos",
    ),
    "info": (
        f"vomstudio info {_SAMPLE_MODEL}",
        "vomstudio info resources/sample/photos --json",
    ),
    "convert": (
        f"vomstudio convert {_SAMPLE_MODEL} cliff.glb",
        f"vomstudio convert {_SAMPLE_MODEL} sample.ply --to-crs EPSG:25833",
    ),
    "fit": (
        "vomstudio fit resources/sample/picks.csv --by pick -o planes.csv",
        "vomstudio fit resources/outcrop/picks.csv --by trace --profile textbook --plot shapes.svg",
    ),
    "stats": (
        "vomstudio stats planes.csv --by set",
        "vomstudio stats planes.csv --by kind --weights error --json",
    ),
    "fold": (
        "vomstudio fold planes.csv",
        "vomstudio fold planes.csv --quality good --json",
    ),
    "sets": (
        "vomstudio sets planes.csv -o sets.csv",
        "vomstudio sets planes.csv --exactly 3 -o three_sets.csv",
    ),
    "repeats": (
        "vomstudio repeats repeated.csv --by bed",
        "vomstudio repeats results/sample.vom",
    ),
    "stereonet": (
        "vomstudio stereonet planes.csv --by kind --contour kamb -o net.svg",
        "vomstudio stereonet planes.csv --fold --errors -o fold.pdf",
    ),
    "rose": (
        "vomstudio rose planes.csv --by kind -o rose.svg",
        "vomstudio rose planes.csv --of dip --bin 15 -o dips.pdf",
    ),
    "slope": (
        "vomstudio slope planes.csv --face 310/75 --friction 35",
        "vomstudio slope planes.csv --facets facets.csv --friction 35 -o slopes.csv",
    ),
    "slip": (
        "vomstudio slip faults.csv",
        "vomstudio slip faults.csv --plot slip.svg",
    ),
    "fractures": (
        "vomstudio fractures results/ortho_drawing.gpkg --layer traces",
        "vomstudio fractures results/ortho_drawing.gpkg --layer traces --plot fractures.svg",
    ),
    "displacement": (
        "vomstudio displacement pairs.csv --fault 90/60 --sigma 0.1",
        "vomstudio displacement pairs.csv --fault 90/60 --bed 270/20 --rake 90",
    ),
    "threepoint": (
        "vomstudio threepoint seam.csv",
        "vomstudio threepoint seam.csv --sigma 5 --json",
    ),
    "log": (
        "vomstudio log boundaries.csv --bed 90/30 --plot log.svg",
        "vomstudio log boundaries.csv --bed 90/30 --bed-error 2 -o log.csv",
    ),
    "ortho": (
        f"vomstudio ortho {_SAMPLE_MODEL} --fold planes.csv -o profile.tif",
        f"vomstudio ortho {_SAMPLE_MODEL} --plane 211/79 --gsd 0.02 --sheet face.pdf -o face.tif",
    ),
    "dem": (
        f"vomstudio dem {_SAMPLE_MODEL} --gsd 0.05 -o heights.tif",
        f"vomstudio dem {_SAMPLE_MODEL} --plane 211/79 --gsd 0.05 --hillshade -o relief.tif",
    ),
    "section": (
        f"vomstudio section {_SAMPLE_MODEL} --plane 211/79 --through 364534,4721859.5,852"
        " -o cut.svg",
        f"vomstudio section {_SAMPLE_MODEL} --plane 121/90 --through 364534,4721859.5,852"
        " -o cut.csv",
    ),
    "extend": (
        f"vomstudio extend {_SAMPLE_MODEL} --plane 315/38 --through 364521.66,4721864.89,850.38"
        " --error 1 -o extended.csv",
        f"vomstudio extend {_SAMPLE_MODEL} --plane 315/38 --through 364521.66,4721864.89,850.38"
        " --error 1 --thickness 0.5 -o beds.gpkg",
    ),
    "surface": (
        f"vomstudio surface {_SAMPLE_MODEL} --around 364530,4721860,850,3 -o deviations.tif",
        f"vomstudio surface {_SAMPLE_MODEL} --around 364530,4721860,850,3 --profiles lines.csv"
        " -o deviations.ply",
    ),
    "measurable": (
        f"vomstudio measurable {_SAMPLE_MODEL} --plane 315/38 --length 4",
        f"vomstudio measurable {_SAMPLE_MODEL} --mean planes.csv --length 4 -o measurable.tif",
    ),
    "facets": (
        f"vomstudio facets {_SAMPLE_MODEL} -o facets.csv",
        f"vomstudio facets {_SAMPLE_MODEL} --propose-sets --labels facets.ply -o facet_sets.csv",
    ),
    "trace": (
        "vomstudio trace resources/outcrop/outcrop.obj --propose -o proposals.csv",
        f"vomstudio trace {_SAMPLE_MODEL} --through way_points.csv -o trace.csv",
    ),
    "plan": (
        "vomstudio plan --camera 'DJI FC3582' --distance 30 --width 80 --height 25 --manner drone",
        "vomstudio plan --camera 23.5x15.6,35,6000x4000 --gsd 0.005 --width 40 --height 15"
        " -o plan.pdf",
    ),
    "check": (
        "vomstudio check resources/sample/photos",
        "vomstudio check resources/sample/photos --distance 20 --json",
    ),
    "frames": (
        "vomstudio frames walk.mp4 -o frames",
        "vomstudio frames walk.mp4 --fps 1 -o one_per_second",
    ),
    "reconstruct": (
        "vomstudio reconstruct resources/sample/photos --quality preview -o model",
        "vomstudio reconstruct resources/sample/photos --gcp resources/sample/control.csv"
        " -o placed_model",
    ),
    "register": (
        "vomstudio register - --pairs points.csv",
        f"vomstudio register {_SAMPLE_MODEL} --pairs tie.csv --crs EPSG:32633 -o placed.ply",
    ),
    "compare": (
        f"vomstudio compare model/model.obj {_SAMPLE_MODEL}",
        f"vomstudio compare model/model.obj {_SAMPLE_MODEL} --m3c2 0.2 -o distances.ply",
    ),
    "export": (
        "vomstudio export results/sample.vom --to gpkg -o layers.gpkg",
        "vomstudio export results/sample.vom --to stereonet -o planes.txt",
    ),
    "completion": (
        "vomstudio completion bash",
        "vomstudio completion fish --json",
    ),
    "project": (f"{_PROJECT_COMMAND} list", f"{_PROJECT_COMMAND} fit --json"),
    "project create": (
        "vomstudio project ridge.vom create",
        "vomstudio project cliff.vom create --json",
    ),
    "project list": (f"{_PROJECT_COMMAND} list", f"{_PROJECT_COMMAND} list --json"),
    "project add-model": (
        f"{_PROJECT_COMMAND} add-model resources/outcrop/outcrop.obj",
        f"{_PROJECT_COMMAND} add-model resources/outcrop/outcrop.obj --crs EPSG:32633",
    ),
    "project register": (
        f"{_PROJECT_COMMAND} register tie.csv --model sample --crs EPSG:32633",
        f"{_PROJECT_COMMAND} register tie.csv --model sample --crs EPSG:32633 --click-sigma 0.01",
    ),
    "project add-picks": (
        f"{_PROJECT_COMMAND} add-picks resources/sample/picks.csv --by pick --type joint"
        " --model sample",
        f"{_PROJECT_COMMAND} add-picks resources/sample/picks.csv --by pick --type bedding"
        " --set west --model sample",
    ),
    "project import": (
        f"{_PROJECT_COMMAND} import stations.csv --model sample",
        f"{_PROJECT_COMMAND} import stations.csv --model sample --json",
    ),
    "project accept": (
        f"{_PROJECT_COMMAND} accept facets --type joint --min-area 0.5 --model sample",
        f"{_PROJECT_COMMAND} accept traces --type bedding --max-lines 10 --model sample",
    ),
    "project accept facets": (
        f"{_PROJECT_COMMAND} accept facets --type joint --model sample",
        f"{_PROJECT_COMMAND} accept facets --type joint --min-area 0.5 --model sample",
    ),
    "project accept traces": (
        f"{_PROJECT_COMMAND} accept traces --type bedding --model sample",
        f"{_PROJECT_COMMAND} accept traces --type bedding --max-lines 10 --model sample",
    ),
    "project set": (
        f"{_PROJECT_COMMAND} set B01 B02 --set upper",
        f"{_PROJECT_COMMAND} set B01 --name base",
    ),
    "project delete": (f"{_PROJECT_COMMAND} delete B01", f"{_PROJECT_COMMAND} delete B02 B03"),
    "project fit": (f"{_PROJECT_COMMAND} fit", f"{_PROJECT_COMMAND} fit B01 B02 --json"),
    "project coverage": (f"{_PROJECT_COMMAND} coverage", f"{_PROJECT_COMMAND} coverage --json"),
    "project profile": (
        f"{_PROJECT_COMMAND} profile textbook",
        f"{_PROJECT_COMMAND} profile error",
    ),
    "project update": (f"{_PROJECT_COMMAND} update", f"{_PROJECT_COMMAND} update --json"),
    "project undo": (f"{_PROJECT_COMMAND} undo", f"{_PROJECT_COMMAND} undo --json"),
    "project redo": (f"{_PROJECT_COMMAND} redo", f"{_PROJECT_COMMAND} redo --json"),
    "project verify": (f"{_PROJECT_COMMAND} verify", f"{_PROJECT_COMMAND} verify --json"),
    "project repair": (f"{_PROJECT_COMMAND} repair", f"{_PROJECT_COMMAND} repair --json"),
    "project compact": (f"{_PROJECT_COMMAND} compact --dry-run", f"{_PROJECT_COMMAND} compact"),
    "project report": (
        f"{_PROJECT_COMMAND} report -o report.html",
        f"{_PROJECT_COMMAND} report -o figures.html --json",
    ),
}
"""Two examples of each command; they run in the folder of the program with the sample."""

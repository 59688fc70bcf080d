"""`vomstudio completion`: what the shells are offered, and `-v`."""

from __future__ import annotations

import shutil
import subprocess

import pytest

from vomstudio.cli import COMMANDS


def completed(script: str, *words: str) -> set[str]:
    """What bash offers for the last word."""
    line = " ".join(f"'{word}'" for word in words)
    code = f"{script}\nCOMP_WORDS=({line}); COMP_CWORD={len(words) - 1}; _vomstudio\n"
    code += 'printf "%s\\n" "${COMPREPLY[@]}"\n'
    done = subprocess.run(["bash", "-c", code], capture_output=True, text=True, check=True)
    return set(done.stdout.split())


@pytest.mark.skipif(shutil.which("bash") is None, reason="needs bash")
def test_bash_completes_commands_options_and_values(run) -> None:
    script = run("completion", "bash").out
    assert completed(script, "vomstudio", "st") == {"stats", "stereonet"}
    assert completed(script, "vomstudio", "") == set(COMMANDS)
    assert "--azimuth" in completed(script, "vomstudio", "slip", "--a")
    assert completed(script, "vomstudio", "slip", "--azimuth", "d") == {"dipdir"}
    # The name of a file follows, which bash completes by itself.
    assert completed(script, "vomstudio", "stats", "--layer", "") == set()
    assert "add-model" in completed(script, "vomstudio", "project", "a.vom", "add")


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_every_command_is_offered_to_every_shell(run, shell: str) -> None:
    ran = run("completion", shell, "--json")
    assert (ran.code, ran.json["shell"]) == (0, shell)
    assert all(command in ran.json["script"] for command in COMMANDS)
    assert run("completion", "tcsh").code == 2


@pytest.mark.skipif(shutil.which("fish") is None, reason="needs fish")
def test_fish_accepts_its_script(run) -> None:
    script = run("completion", "fish").out
    subprocess.run(["fish", "--no-execute"], input=script, text=True, check=True)


def test_verbose_shows_stages_and_codes(run, write) -> None:
    points = write("x,y,z\n0,0,0\n1,0,0\n0,1,0\n")
    plain, verbose = run("fit", points), run("fit", points, "-v")
    assert verbose.out == plain.out
    assert "[frame.assumed]" in verbose.err
    assert "[frame.assumed]" not in plain.err
    assert "Reading" in verbose.err.splitlines()[0]
    assert run("fit", points, "-v", "-q").err == ""

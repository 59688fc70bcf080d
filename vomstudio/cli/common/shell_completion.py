"""Scripts with which bash, zsh and fish complete the commands and their options."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class OptionWords:
    """Option of a command.

    Parameters
    ----------
    names : tuple of str
        Names with their dashes.
    help : str
    takes_value : bool
    choices : tuple of str
        Allowed values; empty if any value is allowed.
    """

    names: tuple[str, ...]
    help: str
    takes_value: bool
    choices: tuple[str, ...]


@dataclass(frozen=True)
class CommandWords:
    """Command with its options.

    Parameters
    ----------
    name : str
    help : str
    words : tuple of str
        Values of its arguments, such as the actions of `project`.
    options : tuple of OptionWords
    """

    name: str
    help: str
    words: tuple[str, ...]
    options: tuple[OptionWords, ...]


def command_words(parser: argparse.ArgumentParser) -> list[CommandWords]:
    """Return the commands of a parser with their options and those of their actions.

    Parameters
    ----------
    parser : ArgumentParser

    Returns
    -------
    list of CommandWords
    """
    commands = []
    for action in parser._actions:
        if not isinstance(action, argparse._SubParsersAction):
            continue
        texts = {choice.dest: choice.help or "" for choice in action._choices_actions}
        for name, command in action.choices.items():
            words, options = _parser_words(command)
            commands.append(CommandWords(name, texts.get(name, ""), words, options))
    return commands


def _parser_words(
    parser: argparse.ArgumentParser,
) -> tuple[tuple[str, ...], tuple[OptionWords, ...]]:
    words: list[str] = []
    options: dict[tuple[str, ...], OptionWords] = {}
    for action in parser._actions:
        choices = tuple(str(choice) for choice in action.choices or ())
        if isinstance(action, argparse._SubParsersAction):
            words += choices
            for child in action.choices.values():
                options |= {option.names: option for option in _parser_words(child)[1]}
        elif action.option_strings:
            names = tuple(action.option_strings)
            text = " ".join((action.help or "").replace("%%", "%").split())
            options.setdefault(names, OptionWords(names, text, action.nargs != 0, choices))
        else:
            words += choices
    return tuple(words), tuple(options.values())


def bash_script(commands: Sequence[CommandWords]) -> str:
    """Return the completion script for bash.

    Parameters
    ----------
    commands : sequence of CommandWords

    Returns
    -------
    str
    """
    names = " ".join(command.name for command in commands)
    words, values = [], []
    for command in commands:
        options = [name for option in command.options for name in option.names]
        words.append(f'    {command.name}) words="{" ".join([*command.words, *options])}" ;;')
        for option in command.options:
            if option.takes_value:
                patterns = "|".join(f"{command.name}:{name}" for name in option.names)
                values.append(f'    {patterns}) values="{" ".join(option.choices)}"; takes=1 ;;')
    return "\n".join(
        [
            "_vomstudio() {",
            '  local current="${COMP_WORDS[COMP_CWORD]}" previous="${COMP_WORDS[COMP_CWORD-1]}"',
            '  local command="${COMP_WORDS[1]}" words="" values="" takes=""',
            "  COMPREPLY=()",
            '  if [ "$COMP_CWORD" -eq 1 ]; then',
            f'    COMPREPLY=( $(compgen -W "{names}" -- "$current") )',
            "    return",
            "  fi",
            '  case "$command:$previous" in',
            *values,
            "  esac",
            '  if [ -n "$takes" ]; then',
            '    COMPREPLY=( $(compgen -W "$values" -- "$current") )',
            "    return",
            "  fi",
            '  case "$command" in',
            *words,
            "  esac",
            '  COMPREPLY=( $(compgen -W "$words" -- "$current") )',
            "}",
            # Names of files if nothing else matches.
            "complete -o default -F _vomstudio vomstudio",
            "",
        ]
    )


def zsh_script(commands: Sequence[CommandWords]) -> str:
    """Return the script for zsh, which uses the completion of bash.

    Parameters
    ----------
    commands : sequence of CommandWords

    Returns
    -------
    str
    """
    header = "autoload -Uz compinit bashcompinit\ncompinit\nbashcompinit\n"
    return header + bash_script(commands)


def fish_script(commands: Sequence[CommandWords]) -> str:
    """Return the script for fish.

    Parameters
    ----------
    commands : sequence of CommandWords

    Returns
    -------
    str
    """
    lines = []
    for command in commands:
        lines.append(
            f"complete -c vomstudio -n __fish_use_subcommand -f -a {command.name}"
            f" -d {_quote(command.help)}"
        )
        command_prefix = f"complete -c vomstudio -n '__fish_seen_subcommand_from {command.name}'"
        if command.words:
            lines.append(f"{command_prefix} -a {_quote(' '.join(command.words))}")
        for option in command.options:
            names = " ".join(
                f"-l {name[2:]}" if name.startswith("--") else f"-s {name[1:]}"
                for name in option.names
            )
            value = f" -x -a {_quote(' '.join(option.choices))}" if option.choices else " -r"
            value = value if option.takes_value else ""
            lines.append(f"{command_prefix} {names}{value} -d {_quote(option.help)}")
    return "\n".join(lines) + "\n"


def _quote(text: str) -> str:
    escaped_text = text.replace("\\", "\\\\").replace("'", "\\'")
    return f"'{escaped_text}'"

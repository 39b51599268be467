"""Bad usage of the command line: what is refused, and the one line that says so."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from typing import Any, Final

import typer
from pydantic import ValidationError
from typer.core import TyperCommand
from typer.models import CommandFunctionType

from zenvoy.cli import exits
from zenvoy.cli.terminal import errors, refuse

_NOT: Final = {
    "int_parsing": "is not a whole number",
    "float_parsing": "is not a number",
    "greater_than_equal": "is not at least {ge}",
    "less_than_equal": "is not at most {le}",
}

# What a run does without, and pages, pictures and tables need: the extra of that name.
_OF_ANALYSIS: Final = {"jinja2", "matplotlib", "pyarrow"}


class App(typer.Typer):
    """A command line whose commands take each option once, but those that say otherwise."""

    def command(
        self, name: str | None = None, **options: Any
    ) -> Callable[[CommandFunctionType], CommandFunctionType]:
        """As of Typer."""
        return super().command(name, **{"cls": _Command, **options})


class _Command(TyperCommand):
    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """As of Typer; refuses an option that is given twice, of which only one would count."""
        _, _, given = self.make_parser(ctx).parse_args(list(args))
        if not any(parameter.is_eager for parameter in given):  # such as --help
            _refuse_twice(given)
        return super().parse_args(ctx, args)


def _refuse_twice(given: Iterable[Any]) -> None:
    for parameter, times in Counter(given).items():
        takes_one = parameter.param_type_name == "option" and not parameter.multiple
        if takes_one and times > 1 and not parameter.is_flag:
            refuse(f"{parameter.opts[0]}: given {times} times; allowed: once")


def outcome(app: typer.Typer, arguments: Sequence[str] | None = None) -> int:
    """Run the command line, that of the process where none is given; the exit code."""
    try:
        code = app(arguments, standalone_mode=False)
    except typer.TyperException as error:
        errors.print(_told(error))
        return error.exit_code
    except (KeyboardInterrupt, typer.Abort):
        return exits.INTERRUPTED
    except ModuleNotFoundError as error:
        package = (error.name or "").partition(".")[0]
        if package not in _OF_ANALYSIS:
            raise
        errors.print(f"{package} is not installed; pip install 'zenvoy[analysis]' has all it takes")
        return exits.FAILED
    except SystemExit as error:  # of shell completion
        return error.code if isinstance(error.code, int) else exits.BAD_INPUT
    return code if isinstance(code, int) else 0


def _told(error: typer.TyperException) -> str:
    """A line, but where no command is given: help."""
    context = getattr(error, "ctx", None)
    if context is None or type(error).__name__ == "NoArgsIsHelpError":
        return error.format_message()
    wrong = error.__cause__
    if isinstance(wrong, ValidationError):
        return "\n".join(_value_told(error, of) for of in wrong.errors())
    text = " ".join(error.format_message().rstrip(".").split())
    path = context.command_path
    return f"{path}: {text[:1].lower()}{text[1:]}; see {path} --help"


def _value_told(error: typer.TyperException, wrong: Any) -> str:
    """What is wrong with the value of an option, as it is told of a scenario's."""
    parameter = getattr(error, "param", None)
    name = (getattr(parameter, "opts", None) or [""])[0]
    name = name if name.startswith("-") else getattr(parameter, "metavar", None) or name
    value = str(wrong["input"])
    text = _NOT.get(wrong["type"], "").format(**wrong.get("ctx", {}))
    if not text:
        text = str(wrong["msg"]).removeprefix("Value error, ").removeprefix(f"'{value}' ")
    return f"{name} {value}: {text.rstrip('.')}"

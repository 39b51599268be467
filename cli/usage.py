"""Bad usage of the command line, and the line that reports it."""

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

_MESSAGES: Final = {
    "int_parsing": "is not a whole number",
    "float_parsing": "is not a number",
    "greater_than_equal": "is not at least {ge}",
    "less_than_equal": "is not at most {le}",
}

# Packages that only some commands need, and the extra that has each; a run needs none of them.
_EXTRAS: Final = {
    "jinja2": "analysis",
    "matplotlib": "analysis",
    "pyarrow": "analysis",
    "optuna": "tune",
    "sqlalchemy": "tune",
}


class App(typer.Typer):
    """A command line that refuses an option given twice, unless the option is repeatable."""

    def command(
        self, name: str | None = None, **options: Any
    ) -> Callable[[CommandFunctionType], CommandFunctionType]:
        """Register a command, as in Typer."""
        return super().command(name, **{"cls": _Command, **options})


class _Command(TyperCommand):
    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse as Typer does; refuse an option that is given twice."""
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
    """Run the command line, by default that of this process; return the exit code."""
    try:
        code = app(arguments, standalone_mode=False)
    except typer.TyperException as error:
        errors.print(_message(error))
        return error.exit_code
    except (KeyboardInterrupt, typer.Abort):
        return exits.INTERRUPTED
    except ModuleNotFoundError as error:
        package = (error.name or "").partition(".")[0]
        if package not in _EXTRAS:
            raise
        errors.print(f"{package} is not installed; run: pip install 'zenvoy[{_EXTRAS[package]}]'")
        return exits.FAILED
    except SystemExit as error:  # raised by shell completion
        return error.code if isinstance(error.code, int) else exits.BAD_INPUT
    return code if isinstance(code, int) else 0


def _message(error: typer.TyperException) -> str:
    """Return a line on the error, or the help if no command is given."""
    context = getattr(error, "ctx", None)
    if context is None or type(error).__name__ == "NoArgsIsHelpError":
        return error.format_message()
    wrong = error.__cause__
    if isinstance(wrong, ValidationError):
        return "\n".join(_value_message(error, of) for of in wrong.errors())
    text = " ".join(error.format_message().rstrip(".").split())
    path = context.command_path
    return f"{path}: {text[:1].lower()}{text[1:]}; see {path} --help"


def _value_message(error: typer.TyperException, wrong: Any) -> str:
    """Return what is wrong with the value of an option, in the form used for scenarios."""
    parameter = getattr(error, "param", None)
    name = (getattr(parameter, "opts", None) or [""])[0]
    name = name if name.startswith("-") else getattr(parameter, "metavar", None) or name
    value = str(wrong["input"])
    text = _MESSAGES.get(wrong["type"], "").format(**wrong.get("ctx", {}))
    if not text:
        text = str(wrong["msg"]).removeprefix("Value error, ").removeprefix(f"'{value}' ")
    return f"{name} {value}: {text.rstrip('.')}"

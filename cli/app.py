"""The `zenvoy` command.

Each command imports its own dependencies, so that `zenvoy show` does not wait for the imports of
`zenvoy run`. filterpy alone takes more than a second.
"""

from __future__ import annotations

from importlib.metadata import version as version_of
from typing import Annotated

import typer

from zenvoy.cli.calibrate_command import calibrate
from zenvoy.cli.certs_command import certs
from zenvoy.cli.compare_laws_command import COMPARE_LAWS_COMMANDS
from zenvoy.cli.convoys_command import convoys
from zenvoy.cli.host_commands import HOST_COMMANDS
from zenvoy.cli.import_commands import IMPORT
from zenvoy.cli.log_commands import LOG_COMMANDS
from zenvoy.cli.mixed_command import MIXED_COMMANDS
from zenvoy.cli.new import NEW
from zenvoy.cli.preview_commands import PREVIEW_COMMANDS
from zenvoy.cli.run_commands import RUN_COMMANDS
from zenvoy.cli.scenario_commands import SCENARIO_COMMANDS
from zenvoy.cli.study_commands import STUDY_COMMANDS
from zenvoy.cli.sweep_command import SWEEP_COMMANDS
from zenvoy.cli.terminal import console
from zenvoy.cli.tune_command import TUNE_COMMANDS
from zenvoy.cli.usage import App
from zenvoy.cli.view_command import view

app = App(
    name="zenvoy",
    help="Emulate convoys of vehicles that talk to each other (V2V).",
    no_args_is_help=True,
    context_settings={"help_option_names": ["-h", "--help"]},
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)


app.add_typer(IMPORT, name="import")
app.add_typer(NEW, name="new")


def _print_version(asked: bool) -> None:
    if asked:
        console.print(f"zenvoy {version_of('zenvoy')}")
        raise typer.Exit


@app.callback()
def zenvoy(
    version: Annotated[
        bool,
        typer.Option(
            "--version", help="Print the version and exit.", callback=_print_version, is_eager=True
        ),
    ] = False,
) -> None:
    """Take the options that stand before a command."""


for command in (
    *RUN_COMMANDS,
    *HOST_COMMANDS,
    *SCENARIO_COMMANDS,
    *PREVIEW_COMMANDS,
    *LOG_COMMANDS,
    *STUDY_COMMANDS,
    *SWEEP_COMMANDS,
    *COMPARE_LAWS_COMMANDS,
    *MIXED_COMMANDS,
    *TUNE_COMMANDS,
    calibrate,
    certs,
    convoys,
    view,
):
    app.command()(command)

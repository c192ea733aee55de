"""The option that says which robot is meant, of a bag with several."""

from __future__ import annotations

import click

robot_option = click.option(
    "--robot", default="", metavar="NODE",
    help="Of a bag with several robots this simulator's, e.g. /cell/flexsim_node.")  # fmt: skip

"""The commands of the command line, one module each: what is read, what is printed."""

from tracker_core.commands import compile as compiling
from tracker_core.commands import filter as filters
from tracker_core.commands import reproduce, run, suggest, sweep

COMMANDS = (run, suggest, filters, sweep, reproduce, compiling)
"""In the order in which the help names them; each adds itself by `add`."""

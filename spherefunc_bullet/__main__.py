"""``python -m spherefunc_bullet``: the console script ``spherefunc`` where it is not on the path."""

from .commands.command_line import main

main()

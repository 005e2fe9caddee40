"""``python -m spherefunc_bullet.compare.bench [BENCH] [OPTIONS]``; without a BENCH, the simulators' speed."""

import sys
from importlib import import_module

import typer

from spherefunc_bullet.console import run

BENCHES = {  # where each is, and its function
    "answers": ("answers", "print_answers"),
    "labels": ("answers", "time_labels"),
    "mechanics": ("answers", "time_mechanics"),
    "scene_stages": ("answers", "time_scenes"),
    "peers": ("peers", "compare_peers"),
}


def main():
    """Run the bench that is named."""
    module, function = "speed", "print_speed"
    if len(sys.argv) > 1 and sys.argv[1] in BENCHES:
        module, function = BENCHES[sys.argv.pop(1)]
    typer.run(getattr(import_module(f".{module}", __package__), function))


if __name__ == "__main__":  # the processes that it starts import this file
    run(main)

"""The subcommands of the shared stack, one file each."""

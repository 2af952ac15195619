"""One module per ``patrol`` subcommand: its options, and what it calls."""

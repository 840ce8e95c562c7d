"""The command line of fingerdesign: one file a subcommand, loaded when it is asked for."""

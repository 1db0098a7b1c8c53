"""The command line ``gnc``: one file a command."""

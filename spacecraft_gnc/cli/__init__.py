"""Command line ``gnc``: one file per command."""

"""Audit library: the ledger of checks, the evidence that they read."""

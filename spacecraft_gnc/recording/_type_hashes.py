"""Hashes of the message types that this version reads and writes (REP-2011, ``RIHS01``)."""

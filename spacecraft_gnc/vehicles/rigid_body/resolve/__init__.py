"""Every recorded step solved again: numbers, prices and a figure."""

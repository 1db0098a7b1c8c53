"""Optimal control of an attitude with two wheels: problem, own SQP, and IPOPT as its reference."""

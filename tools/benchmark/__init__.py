"""The figures every change keeps, measured: each with its unit and its limit."""

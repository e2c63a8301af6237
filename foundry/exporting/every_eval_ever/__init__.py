"""Exports sweeps as records of Every Eval Ever (a public collection of results), checked against its schema.

`eval.schema.json` comes unchanged from the package `every-eval-ever` 0.3.0, under the MIT licence next to it.
"""

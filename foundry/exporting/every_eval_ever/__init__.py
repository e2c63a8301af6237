"""Records of Every Eval Ever, held against its schema.

`eval.schema.json` is that of the package `every-eval-ever` 0.3.0, unchanged, under the MIT licence beside it.
"""

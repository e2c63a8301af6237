"""The commands of the command line; every module in this package is found automatically.

Only the modules of this package and `foundry.cli` call `print`. Importing a module must import nothing heavy, so that
`--help` is quick.
"""

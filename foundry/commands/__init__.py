"""The commands of the command line; every module in this package is found automatically.

Only these modules and `foundry.cli` print. Importing a module must import nothing heavy, so that `--help` is quick.
"""

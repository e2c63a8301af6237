"""The commands of the command line; each module of this package is found by being here.

With `foundry.cli`, the only code that prints. At import a module brings in nothing heavy, so that `--help` is quick.
"""

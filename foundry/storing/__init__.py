"""The only code that knows the layout of outputs/."""

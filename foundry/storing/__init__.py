"""The only code that knows the layout of folders in outputs/."""

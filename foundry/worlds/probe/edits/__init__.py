"""The shipped edits, `EDITS` of one module for each form of the world that asks; `any` for those of every form."""

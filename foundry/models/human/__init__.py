"""People who answer in place of a model, and the desk that puts questions to them."""

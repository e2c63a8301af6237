"""A scripted model that returns faulty replies on purpose."""

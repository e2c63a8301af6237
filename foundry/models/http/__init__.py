"""What backends over HTTP share."""

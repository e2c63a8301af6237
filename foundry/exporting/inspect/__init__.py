"""Logs of Inspect, written by its own API."""
